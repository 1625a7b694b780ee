//! The three smooth modes and the impact law (model.md section 1, paper [1]–[3]).
