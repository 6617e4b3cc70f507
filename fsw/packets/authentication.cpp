#include "fsw/packets/authentication.hpp"

#include <algorithm>

#include "fsw/base/argument.hpp"
#include "fsw/base/result.hpp"

namespace ilp {
namespace {

constexpr std::size_t primary_bytes = 6;
constexpr std::uint32_t window = 64;

std::uint32_t number(std::span<const std::uint8_t> bytes) {
  std::uint32_t value = 0;
  for (const std::uint8_t byte : bytes) value = (value << 8U) | byte;
  return value;
}
void put_number(std::span<std::uint8_t> bytes, std::size_t value) {
  for (std::size_t i = bytes.size(); i > 0; --i, value >>= 8U) bytes[i - 1] = static_cast<std::uint8_t>(value);
}

HmacSha256 code_of(std::span<const std::uint8_t> key, std::span<const std::uint8_t> octets) {
  const std::array<std::span<const std::uint8_t>, 1> parts{octets};
  return hmac_sha256(key, parts);
}

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}
std::span<const char> without_blanks(std::span<const char> text) {
  while (!text.empty() && is_blank(text.front())) text = text.subspan(1);
  while (!text.empty() && is_blank(text.back())) text = text.first(text.size() - 1);
  return text;
}
Result<int> digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return StatusCode::parse_error;
}

}  // namespace

Authenticator::Association* Authenticator::find(std::uint16_t spi) {
  for (Association& association : associations_) {
    if (association.spi == spi) return &association;
  }
  return nullptr;
}

Status Authenticator::add(std::uint16_t spi, std::span<const std::uint8_t> key) {
  if (find(spi) != nullptr) return out_of_range(Argument::security_parameter_index, spi);
  if (key.size() < min_key_bytes || key.size() > max_key_bytes) {
    return out_of_range(Argument::key_length, key.size());
  }
  Association association;
  association.spi = spi;
  association.key_bytes = key.size();
  std::copy(key.begin(), key.end(), association.key.begin());
  if (associations_.push_back(association)) return {};
  return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(associations_.size() + 1),
          static_cast<std::int64_t>(limits::max_security_associations)};
}

std::span<const std::uint8_t> Authenticator::first_key() const {
  if (associations_.empty()) return {};
  const Association& first = associations_[0];
  return std::span(first.key).first(std::min(first.key_bytes, max_key_bytes));
}

Status Authenticator::add_line(std::span<const char> line) {
  std::uint32_t spi = 0;
  std::size_t digits = 0;
  for (; digits < line.size() && digits < 5 && line[digits] >= '0' && line[digits] <= '9'; ++digits) {
    spi = 10 * spi + static_cast<std::uint32_t>(line[digits] - '0');
  }
  if (digits == 0 || digits == line.size() || !is_blank(line[digits]) || spi == 0 || spi > 65535) {
    return StatusCode::parse_error;
  }
  const std::span<const char> hex = without_blanks(line.subspan(digits));
  std::array<std::uint8_t, max_key_bytes> key{};
  if (hex.size() % 2 != 0 || hex.size() > 2 * key.size()) return StatusCode::parse_error;
  for (std::size_t i = 0; i < hex.size(); ++i) {
    ILP_TAKE(const int value, digit(hex[i]));
    key[i / 2] = static_cast<std::uint8_t>((key[i / 2] << 4U) | value);
  }
  return add(static_cast<std::uint16_t>(spi), std::span(key).first(hex.size() / 2));
}

Status Authenticator::add_keys(std::span<const char> text) {
  for (std::int64_t number = 1; !text.empty(); ++number) {
    const auto end = static_cast<std::size_t>(std::find(text.begin(), text.end(), '\n') - text.begin());
    std::span<const char> line = text.first(end);
    line = line.first(static_cast<std::size_t>(std::find(line.begin(), line.end(), '#') - line.begin()));
    line = without_blanks(line);
    if (!line.empty()) {
      const Status status = add_line(line);
      if (status.is(StatusCode::capacity_exceeded)) return status;
      if (!status.ok()) return {StatusCode::parse_error, number};
    }
    text = text.subspan(std::min(end + 1, text.size()));
  }
  return {};
}

Status Authenticator::open(std::span<std::uint8_t> packet, std::size_t& bytes) {
  bytes = 0;
  // One octet of data at least, as a space packet has.
  if (packet.size() < primary_bytes + security_bytes + 1) return StatusCode::authentication_missing;
  const auto spi = static_cast<std::uint16_t>(number(packet.subspan(primary_bytes, 2)));
  const std::uint32_t sequence = number(packet.subspan(primary_bytes + 2, 4));
  Association* const association = find(spi);
  if (association == nullptr) return {StatusCode::authentication_key, spi, sequence};
  const std::size_t covered = packet.size() - security_trailer_bytes;
  const HmacSha256 code = code_of(std::span(association->key).first(association->key_bytes), packet.first(covered));
  if (!equal_in_constant_time(std::span(code).first(security_trailer_bytes), packet.subspan(covered))) {
    return {StatusCode::authentication_code, spi, sequence};
  }
  if (sequence > association->highest) {
    const std::uint32_t ahead = sequence - association->highest;
    association->seen = ahead < window ? association->seen << ahead : 0;
    association->seen |= 1;
    association->highest = sequence;
  } else {
    const std::uint32_t behind = association->highest - sequence;
    const std::uint64_t bit = behind < window ? std::uint64_t{1} << behind : 0;
    if (bit == 0 || (association->seen & bit) != 0) return {StatusCode::authentication_replay, spi, sequence};
    association->seen |= bit;
  }
  std::copy(packet.begin() + primary_bytes + security_header_bytes, packet.begin() + static_cast<long>(covered),
            packet.begin() + primary_bytes);
  bytes = packet.size() - security_bytes;
  put_number(packet.subspan(4, 2), bytes - primary_bytes - 1);
  return {};
}

SequenceMarks Authenticator::marks() const {
  SequenceMarks marks;
  for (const Association& association : associations_) {
    static_cast<void>(marks.push_back({association.highest, association.spi, 0}));
  }
  return marks;
}

void Authenticator::resume(const SequenceMarks& marks) {
  for (const SequenceMark& mark : marks) {
    Association* const association = find(mark.spi);
    if (association == nullptr || mark.highest < association->highest) continue;
    association->highest = mark.highest;
    association->seen = ~std::uint64_t{0};
  }
}

Status seal(std::span<const std::uint8_t> packet, std::uint16_t spi, std::uint32_t sequence,
            std::span<const std::uint8_t> key, std::span<std::uint8_t> out, std::size_t& bytes) {
  bytes = 0;
  if (packet.size() <= primary_bytes) return {StatusCode::truncated, static_cast<std::int64_t>(packet.size())};
  const std::size_t length = packet.size() + security_bytes;
  if (length > out.size() || length > limits::max_packet_bytes) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(length), static_cast<std::int64_t>(out.size())};
  }
  std::copy(packet.begin(), packet.begin() + primary_bytes, out.begin());
  put_number(out.subspan(4, 2), length - primary_bytes - 1);
  put_number(out.subspan(primary_bytes, 2), spi);
  put_number(out.subspan(primary_bytes + 2, 4), sequence);
  std::copy(packet.begin() + primary_bytes, packet.end(), out.begin() + primary_bytes + security_header_bytes);
  const std::size_t covered = length - security_trailer_bytes;
  const HmacSha256 code = code_of(key, out.first(covered));
  std::copy_n(code.begin(), security_trailer_bytes, out.begin() + static_cast<long>(covered));
  bytes = length;
  return {};
}

}  // namespace ilp
