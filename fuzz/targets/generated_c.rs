#![no_main]

sesc_fuzz::target!(sesc_fuzz::generated_c::compared);
