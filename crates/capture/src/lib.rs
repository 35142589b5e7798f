//! Vendor motion-capture files to recordings and back: Motive CSV, Qualisys TSV.
