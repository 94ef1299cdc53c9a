//! Closest-point, insidedness and segment queries on a part.
