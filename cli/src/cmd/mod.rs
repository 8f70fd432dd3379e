//! The subcommands, one file each: its flags, its run, its report.

pub mod accuracy;
pub mod bench;
pub mod build;
pub mod cast;
pub mod compare;
pub mod completions;
pub mod demo;
pub mod export;
pub mod info;
pub mod render;
pub mod selftest;
pub mod thesis;
pub mod verify;
pub mod view;
