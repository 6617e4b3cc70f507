// Reads and writes complete files, detects changed files, and makes names from downlinked data safe for files and
// pages. Error messages name the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ilp::host {

/// Reads all bytes of a file. Throws std::runtime_error.
[[nodiscard]] std::vector<std::uint8_t> read_file(const std::filesystem::path& path);
/// Writes under a temporary name and renames the file, so that a reader never sees half a file. Throws
/// std::runtime_error.
void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);
/// As write_file, but does not touch a file that already holds these bytes: its modification time stays.
void update_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void update_file(const std::filesystem::path& path, std::string_view text);
/// As update_file with the bytes that `write` puts into the stream. They need not fit into memory.
void update_file(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);
/// Renames the finished file `part` to `whole`. If `whole` already holds the same bytes, only `part` is removed. Throws
/// std::runtime_error.
void move_into_place(const std::filesystem::path& part, const std::filesystem::path& whole);
/// Creates the folder with its parents. Throws std::runtime_error if it cannot be created or is not writable.
void make_output_folder(const std::filesystem::path& folder);

// Whether a file has changed.

/// Size and times of a regular file, from the file system. Every write changes `changed_ns` (ctime), and no program can
/// set it back.
struct FileState {
  std::uint64_t bytes = 0;
  std::int64_t modified_ns = 0, changed_ns = 0;
  bool operator==(const FileState&) const = default;
};
/// Empty if there is no regular file.
[[nodiscard]] std::optional<FileState> state_of(const std::filesystem::path& path);
/// Fingerprint of the content (digest.hpp), not for security. Empty if the file cannot be read.
[[nodiscard]] std::optional<std::uint64_t> content_digest(const std::filesystem::path& path);
/// Text for a file that could not be written: the cause, and what to do. `cause` is errno.
[[nodiscard]] std::string write_failure(int cause);
/// Text for a file that could not be read, likewise.
[[nodiscard]] std::string read_failure(int cause);

// Names.

/// The first 128 octets of the last path component, with all characters but ASCII letters, digits and `._-+@` replaced
/// by `_`. Empty if the component is empty or has dots only.
[[nodiscard]] std::string safe_name(std::string_view name);
/// The name without its extension.
[[nodiscard]] std::string stem(std::string_view name);
/// Key of an image in flight, ground and references: its file name without folder and extension, with `_` for blanks. A
/// name that the flight cannot carry (other characters, or more than `longest_image_key` octets) is replaced by a safe,
/// cut name with eight digits of the original's digest. The key of a key is the same key.
[[nodiscard]] std::string image_key(std::string_view file_name);
inline constexpr std::size_t longest_image_key = 56;
/// The number with at least six digits: 000042.
[[nodiscard]] std::string six_digits(std::int64_t number);

}  // namespace ilp::host
