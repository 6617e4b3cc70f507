// Files that came down, on the ground's disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace ilp::console {

/// Creates the folder with its parents. std::runtime_error.
void make_folder(const std::filesystem::path& folder);

/// Replaces the content of a file; after a failure it has the old content. std::runtime_error.
void replace_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

/// Stores a file; returns an empty text when it is complete on disk under its name, else the reason. A file of this
/// name with other content is left alone, because it belongs to another flight.
[[nodiscard]] std::string keep_file(const std::filesystem::path& folder, const std::string& name,
                                    std::span<const std::uint8_t> bytes);

}  // namespace ilp::console
