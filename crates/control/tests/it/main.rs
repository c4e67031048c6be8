//! The laws, by tables and by properties.

mod schema;
