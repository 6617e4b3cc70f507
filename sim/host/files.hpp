// Reads and writes whole files; error messages name the file. Names that came down are made safe for files and pages.
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

/// Throws std::runtime_error.
[[nodiscard]] std::vector<std::uint8_t> read_file(const std::filesystem::path& path);
/// Writes under a temporary name first, so that a reader never sees half a file. Throws std::runtime_error.
void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);
/// As write_file, but a file that holds these bytes already is left as it is, with its time.
void update_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void update_file(const std::filesystem::path& path, std::string_view text);
/// The same with all that `write` puts into the stream, which need not fit into memory.
void update_file(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);
/// Renames the finished file `part` to `whole`. Where `whole` holds the same bytes already, it is left as it is and
/// `part` is removed. Throws std::runtime_error.
void move_into_place(const std::filesystem::path& part, const std::filesystem::path& whole);
/// Creates the folder with its parents; throws std::runtime_error when it is not writable.
void make_output_folder(const std::filesystem::path& folder);

// Whether a file has changed.

/// What the file system says of a regular file. Every program that writes to a file changes `changed_ns`, and no
/// program can set it back.
struct FileState {
  std::uint64_t bytes = 0;
  std::int64_t modified_ns = 0, changed_ns = 0;
  bool operator==(const FileState&) const = default;
};
/// None where there is no regular file.
[[nodiscard]] std::optional<FileState> state_of(const std::filesystem::path& path);
/// Fingerprint of the content; not for security. None when the file cannot be read.
[[nodiscard]] std::optional<std::uint64_t> content_digest(const std::filesystem::path& path);
/// Why a file could not be written, and what to do; `cause` is errno.
[[nodiscard]] std::string write_failure(int cause);
/// The same for a file that cannot be read.
[[nodiscard]] std::string read_failure(int cause);

// Names.

/// The last path component, with everything but letters, digits and `._-+@` replaced by `_`; empty for none or dots
/// only.
[[nodiscard]] std::string safe_name(std::string_view name);
/// The name without its extension.
[[nodiscard]] std::string stem(std::string_view name);
/// By which an image is known everywhere, from the flight to its references: the name of its file without folder and
/// extension. Blanks become `_`. What the flight cannot carry (other letters, more than `longest_image_key` octets) is
/// replaced, and eight digits of the name's digest tell it from others; a name that was made so stays as it is.
[[nodiscard]] std::string image_key(std::string_view file_name);
inline constexpr std::size_t longest_image_key = 56;
/// KKKKKK
[[nodiscard]] std::string six_digits(std::int64_t number);

}  // namespace ilp::host
