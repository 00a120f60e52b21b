//! Comments are short, begin with their subject and use the project's words.
