//! Who shows what: the cut through the overlap that is noticed least.
