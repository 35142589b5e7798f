//! The steps from session to report in order, with files; the facade for library users.
