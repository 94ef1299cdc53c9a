//! Facts about limit surfaces and crusts.
