#include "sim/ground/tasks/sealed_block.hpp"

#include <array>
#include <istream>
#include <ostream>
#include <stdexcept>

#include "fsw/base/crc.hpp"

namespace ilp::tasks {
namespace {

constexpr std::uint32_t largest_block = 1U << 30U;

using Word = std::array<char, 4>;

Word word_of(std::uint32_t value) {
  return {static_cast<char>(value), static_cast<char>(value >> 8U), static_cast<char>(value >> 16U),
          static_cast<char>(value >> 24U)};
}

std::uint32_t value_of(const Word& word) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8U | static_cast<unsigned char>(word[i]);
  return value;
}

}  // namespace

void write_block(std::ostream& stream, std::span<const std::uint8_t> bytes) {
  if (bytes.size() > largest_block) throw std::runtime_error("a block of work is above 1 GiB");
  for (const std::uint32_t value : {static_cast<std::uint32_t>(bytes.size()), crc32(bytes)}) {
    stream.write(word_of(value).data(), 4);
  }
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

std::optional<std::vector<std::uint8_t>> read_block(std::istream& stream) {
  Word length{}, crc{};
  if (stream.peek() == std::istream::traits_type::eof()) return std::nullopt;
  if (!stream.read(length.data(), 4) || !stream.read(crc.data(), 4) || value_of(length) > largest_block)
    throw std::runtime_error("a block of work is damaged");
  std::vector<std::uint8_t> bytes(value_of(length));
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
    throw std::runtime_error("a block of work is cut off");
  if (crc32(bytes) != value_of(crc)) throw std::runtime_error("a block of work is damaged");
  return bytes;
}

}  // namespace ilp::tasks
