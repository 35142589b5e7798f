//! Distances, contacts and hulls of fingertips and objects.
