// Checksums of a database's pages and of the frames of its write-ahead log, and correction of one flipped bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

inline constexpr std::size_t page_bytes = 4096;
/// Space at the end of each page that SQLite leaves unused: CRC-32C and the sum of the 32-bit words.
inline constexpr std::size_t page_checksum_bytes = 8;

using Page = std::span<std::uint8_t, page_bytes>;

/// Writes the checksums of a page. `number` counts from 1 and is part of the checked data, so that a page at the wrong
/// position is detected.
void seal_page(std::uint32_t number, Page page);

enum class PageState : std::uint8_t { valid, mended, damaged };
/// Checks a page and corrects one flipped bit in it: the CRC locates the bit, and the sum must agree.
PageState check_page(std::uint32_t number, Page page);

/// A frame of the log is a header of 24 octets and a page (https://www.sqlite.org/fileformat2.html, "The Write-Ahead
/// Log"): page number, size of the database if the frame ends a transaction, two salts, two checksums that continue
/// those of the previous frame.
inline constexpr std::size_t log_header_bytes = 32;
inline constexpr std::size_t frame_header_bytes = 24;
inline constexpr std::size_t frame_bytes = frame_header_bytes + page_bytes;

struct FrameSum {
  std::uint32_t first = 0, second = 0;
  bool operator==(const FrameSum&) const = default;
};

/// Continues a checksum of the log over `bytes`, a multiple of 8 octets. `big_endian` is the byte order of the log's
/// words.
[[nodiscard]] FrameSum add_to_frame_sum(FrameSum sum, std::span<const std::uint8_t> bytes, bool big_endian);
/// The checksum of a frame: over the first 8 octets of its header, and its page.
[[nodiscard]] FrameSum frame_sum(FrameSum before, std::span<const std::uint8_t, frame_bytes> frame, bool big_endian);
/// The checksum in the header. The header's numbers are always big-endian.
[[nodiscard]] FrameSum stated_frame_sum(std::span<const std::uint8_t, frame_header_bytes> header);
[[nodiscard]] bool ends_transaction(std::span<const std::uint8_t, frame_header_bytes> header);

}  // namespace ilp
