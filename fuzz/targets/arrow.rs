#![no_main]

sesc_fuzz::target!(sesc_fuzz::arrow::arrow);
