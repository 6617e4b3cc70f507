// Files that came down, on the ground's disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace ilp::sim {

/// Creates the folder with its parents. std::runtime_error.
void make_folder(const std::filesystem::path& folder);

/// The file has this content, whole and on disk, or what it had before. std::runtime_error.
void replace_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

/// Empty when the file is held: on disk, whole, under its name. Else why not. A file of this name with other content is
/// left alone: it is another flight's.
[[nodiscard]] std::string keep_file(const std::filesystem::path& folder, const std::string& name,
                                    std::span<const std::uint8_t> bytes);

}  // namespace ilp::sim
