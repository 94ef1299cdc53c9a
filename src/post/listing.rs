//! What came out, in words and figures.
