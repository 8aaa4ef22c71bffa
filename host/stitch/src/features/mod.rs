//! Natural features: found, described, matched.
