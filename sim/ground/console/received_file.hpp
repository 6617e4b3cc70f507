// Stores downlinked files on the ground's disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace ilp::console {

/// Creates the folder with its parents. Throws std::runtime_error.
void make_folder(const std::filesystem::path& folder);

/// Replaces the content of a file. If it throws std::runtime_error, the file has its old content.
void replace_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

/// Stores a file. Returns an empty text if it is complete on disk under its name, else the reason. Does not replace a
/// file of this name with other content, because that belongs to another flight.
[[nodiscard]] std::string keep_file(const std::filesystem::path& folder, const std::string& name,
                                    std::span<const std::uint8_t> bytes);

}  // namespace ilp::console
