// Reads and writes whole files; error messages name the file. Names that came down are made safe for files and pages.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ilp::host {

/// Throws std::runtime_error.
[[nodiscard]] std::vector<std::uint8_t> read_file(const std::filesystem::path& path);
/// Writes under a temporary name first, so that a reader never sees half a file. Throws std::runtime_error.
void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);
/// Creates the folder with its parents; throws std::runtime_error when it is not writable.
void make_output_folder(const std::filesystem::path& folder);

/// Why a file could not be written, and what to do; `cause` is errno.
[[nodiscard]] std::string write_failure(int cause);

// Names.

/// The last path component, with everything but letters, digits and `._-+@` replaced by `_`; empty for none or dots
/// only.
[[nodiscard]] std::string safe_name(std::string_view name);
/// The name without its extension.
[[nodiscard]] std::string stem(std::string_view name);
/// KKKKKK
[[nodiscard]] std::string six_digits(std::int64_t number);

}  // namespace ilp::host
