// Whole files in and out, with messages that name the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ilp::ground {

/// Throws std::runtime_error.
[[nodiscard]] std::vector<std::uint8_t> read_file(const std::filesystem::path& path);
/// Under a temporary name first, so that nobody takes half a file for the whole. Throws std::runtime_error.
void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);
/// Creates the folder with its parents; throws std::runtime_error when it is not writable.
void make_output_folder(const std::filesystem::path& folder);

}  // namespace ilp::ground
