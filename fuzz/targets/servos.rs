#![no_main]

sesc_fuzz::target!(sesc_fuzz::files::servos);
