//! Vendor text in, recordings out, and back. Everything read here is made here.

mod suite {
    //! `text` makes vendor files; the others hold one kind of check each.
    mod blocks;
    mod c3d;
    mod damage;
    mod motive;
    mod qualisys;
    mod roles;
    mod round_trip;
    mod row_typed;
    mod text;
    mod trc;
    mod trc_write;
}
