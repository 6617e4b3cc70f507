#include "fsw/vision/codec/metadata.hpp"

#include <bit>
#include <cmath>

#include "fsw/base/argument.hpp"

namespace ilp {
namespace {

constexpr double exact_integers_end = 9007199254740992.0;  // 2^53
constexpr int max_decimals = 15;
constexpr double powers_of_ten[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
constexpr int mantissa_bits = 52;
constexpr int exponent_bias = 1023;

bool key_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' || c == '-';
}

// UTF-8 is accepted.
bool value_character(char c) {
  return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
}

bool valid_key(std::string_view key) {
  if (key.empty()) return false;
  for (const char c : key) {
    if (!key_character(c)) return false;
  }
  return true;
}

bool valid_value(std::string_view value) {
  for (const char c : value) {
    if (!value_character(c)) return false;
  }
  return true;
}

struct Digits {
  char text[24];
  std::size_t size = 0;
  [[nodiscard]] std::string_view view() const { return {text, size}; }
};

Digits decimal_digits(std::uint64_t value) {
  char reversed[24];
  std::size_t count = 0;
  do {
    reversed[count++] = static_cast<char>('0' + value % 10);
    value /= 10;
  } while (value != 0);
  Digits digits;
  while (count > 0) digits.text[digits.size++] = reversed[--count];
  return digits;
}

// Reads the digits of a number from the front of `text`.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : at_(text.data()), end_(text.data() + text.size()) {}

  [[nodiscard]] bool done() const { return at_ == end_; }
  [[nodiscard]] char peek() const { return done() ? '\0' : *at_; }
  bool accept(char c) {
    if (peek() != c || done()) return false;
    ++at_;
    return true;
  }
  [[nodiscard]] bool at_digit() const { return !done() && *at_ >= '0' && *at_ <= '9'; }
  unsigned digit() { return static_cast<unsigned>(*at_++ - '0'); }
  /// Returns 16 if there is no hexadecimal digit.
  [[nodiscard]] unsigned hex_value() const {
    const char c = peek();
    if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
    if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a') + 10;
    return 16;
  }
  void skip() { ++at_; }
  bool accept_word(std::string_view word) {
    if (static_cast<std::size_t>(end_ - at_) < word.size() || std::string_view(at_, word.size()) != word) return false;
    at_ += word.size();
    return true;
  }

 private:
  const char* at_;
  const char* end_;
};

// A number with more binary digits than a double holds at this exponent is refused, never rounded.
bool scan_hexadecimal(Scanner& in, double& value) {
  std::uint64_t mantissa = in.hex_value();
  if (mantissa > 1) return false;
  in.skip();
  int exponent = 0;
  if (in.accept('.')) {
    while (in.hex_value() < 16) {  // bound: the octets of the text
      if (mantissa >> 56U != 0) return false;
      mantissa = (mantissa << 4U) | in.hex_value();
      exponent -= 4;
      in.skip();
    }
  }
  if (!in.accept('p')) return false;
  const bool negative = in.accept('-');
  if (!negative && !in.accept('+')) return false;
  int power = 0;
  if (!in.at_digit()) return false;
  while (in.at_digit()) {  // bound: the octets of the text
    power = power * 10 + static_cast<int>(in.digit());
    if (power > 2000) return false;
  }
  if (mantissa >= std::uint64_t{1} << (mantissa_bits + 1)) return false;
  exponent += negative ? -power : power;
  if (exponent < -1074 || exponent > exponent_bias) return false;
  // Two exact steps, each within the range of a double, even for subnormal results.
  const int first = exponent / 2;
  const auto power_of_two = [](int e) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(e + exponent_bias) << mantissa_bits);
  };
  value = static_cast<double>(mantissa) * power_of_two(first) * power_of_two(exponent - first);
  return value < HUGE_VAL;
}

// At most 2^53 and a power of ten up to 22: both exact, so that one division rounds correctly (W. D. Clinger, "How to
// read floating point numbers accurately", PLDI 1990).
bool scan_decimal(Scanner& in, double& value) {
  if (!in.at_digit()) return false;
  std::uint64_t digits = 0;
  int decimals = 0;
  bool fraction = false;
  while (in.at_digit() || (!fraction && in.peek() == '.' && !in.done())) {  // bound: the octets of the text
    if (in.accept('.')) {
      fraction = true;
      continue;
    }
    digits = digits * 10 + in.digit();
    if (fraction) ++decimals;
    if (digits > static_cast<std::uint64_t>(exact_integers_end) || decimals > 22) return false;
  }
  value = static_cast<double>(digits) / powers_of_ten[decimals];
  return true;
}

bool scan_real(Scanner& in, double& value) {
  const bool negative = in.accept('-');
  bool good = true;
  if (in.accept_word("inf")) {
    value = HUGE_VAL;
  } else if (in.accept_word("nan")) {
    value = std::bit_cast<double>(std::uint64_t{0x7ff8000000000000});
  } else if (in.accept_word("0x")) {
    good = scan_hexadecimal(in, value);
  } else {
    good = scan_decimal(in, value);
  }
  if (negative) value = -value;
  return good;
}

}  // namespace

void MetadataWriter::put(char c) {
  if (size_ < buffer_.size()) {
    buffer_[size_++] = static_cast<std::uint8_t>(c);
  } else {
    overflow_ = true;
  }
}

void MetadataWriter::put(std::string_view text) {
  for (const char c : text) put(c);
}

bool MetadataWriter::begin(std::string_view key) {
  if (!status_.ok()) return false;
  if (!valid_key(key)) {
    status_ = out_of_range(Argument::text, size_);
    return false;
  }
  put(key);
  put('=');
  return true;
}

// A line that does not fit is removed as a whole.
void MetadataWriter::end(std::size_t start) {
  put('\n');
  if (!overflow_) return;
  size_ = start;
  status_ = {StatusCode::capacity_exceeded, static_cast<std::int64_t>(start) + 1,
             static_cast<std::int64_t>(buffer_.size())};
}

void MetadataWriter::text(std::string_view key, std::string_view value) {
  const std::size_t start = size_;
  if (status_.ok() && !valid_value(value)) {
    status_ = out_of_range(Argument::text, start);
  }
  if (!begin(key)) return;
  put(value);
  end(start);
}

void MetadataWriter::integer(std::string_view key, std::int64_t value) {
  const std::size_t start = size_;
  if (!begin(key)) return;
  if (value < 0) put('-');
  const auto bits = static_cast<std::uint64_t>(value);
  put(decimal_digits(value < 0 ? ~bits + 1 : bits).view());
  end(start);
}

void MetadataWriter::real(std::string_view key, double value) {
  reals(key, {&value, 1});
}

void MetadataWriter::reals(std::string_view key, std::span<const double> values) {
  const std::size_t start = size_;
  if (!begin(key)) return;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) put(' ');
    put_real(values[i]);
  }
  end(start);
}

void MetadataWriter::put_real(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const std::uint64_t fraction = bits & ((std::uint64_t{1} << mantissa_bits) - 1);
  const int biased = static_cast<int>((bits >> mantissa_bits) & 0x7ffU);
  if (biased == 0x7ff && fraction != 0) {
    put("nan");
    return;
  }
  if ((bits >> 63U) != 0) put('-');
  if (biased == 0x7ff) {
    put("inf");
    return;
  }
  const double magnitude = std::fabs(value);
  for (int decimals = 0; decimals <= max_decimals; ++decimals) {
    const double power = powers_of_ten[decimals];
    const double scaled = std::floor(magnitude * power + 0.5);
    if (scaled >= exact_integers_end / 8) break;  // beyond 15 digits a decimal is no easier to read
    if (scaled / power != magnitude) continue;
    const auto digits = static_cast<std::uint64_t>(scaled);
    const auto unit = static_cast<std::uint64_t>(power);
    put(decimal_digits(digits / unit).view());
    if (decimals == 0) return;
    put('.');
    const Digits rest = decimal_digits(digits % unit);
    for (std::size_t i = rest.size; i < static_cast<std::size_t>(decimals); ++i) put('0');
    put(rest.view());
    return;
  }
  const bool subnormal = biased == 0;
  put(subnormal ? "0x0." : "0x1.");
  std::uint64_t left = fraction << 12U;
  do {
    put("0123456789abcdef"[left >> 60U]);
    left <<= 4U;
  } while (left != 0);
  const int exponent = subnormal ? 1 - exponent_bias : biased - exponent_bias;
  put('p');
  put(exponent < 0 ? '-' : '+');
  put(decimal_digits(static_cast<std::uint64_t>(exponent < 0 ? -exponent : exponent)).view());
}

Status MetadataReader::next(std::size_t& position, std::string_view& key, std::string_view& value) const {
  const auto* text = reinterpret_cast<const char*>(bytes_.data());
  while (position < bytes_.size()) {
    const std::size_t start = position;
    std::size_t equals = bytes_.size();
    std::size_t end = start;
    while (end < bytes_.size() && text[end] != '\n') {
      if (text[end] == '=' && equals == bytes_.size()) equals = end;
      ++end;
    }
    position = end + 1;
    if (equals >= end) continue;
    key = {text + start, equals - start};
    value = {text + equals + 1, end - equals - 1};
    if (valid_key(key) && valid_value(value)) return {};
  }
  return StatusCode::end_of_stream;
}

Status MetadataReader::text(std::string_view key, std::string_view& value) const {
  std::size_t position = 0;
  std::string_view k;
  while (next(position, k, value).ok()) {  // bound: the lines of the text
    if (k == key) return {};
  }
  value = {};
  return StatusCode::not_found;
}

Status MetadataReader::integer(std::string_view key, std::int64_t& value) const {
  std::string_view text_value;
  ILP_TRY(text(key, text_value));
  Scanner in(text_value);
  const bool negative = in.accept('-');
  const std::uint64_t most = (std::uint64_t{1} << 63U) - (negative ? 0 : 1);
  std::uint64_t magnitude = 0;
  bool good = in.at_digit();
  while (good && in.at_digit()) {  // bound: the octets of the text
    const unsigned digit = in.digit();
    good = magnitude <= (most - digit) / 10;
    magnitude = magnitude * 10 + digit;
  }
  if (!good || !in.done()) {
    return {StatusCode::parse_error, reinterpret_cast<const std::uint8_t*>(text_value.data()) - bytes_.data()};
  }
  value = static_cast<std::int64_t>(negative ? ~magnitude + 1 : magnitude);
  return {};
}

Status MetadataReader::real(std::string_view key, double& value) const {
  return reals(key, {&value, 1});
}

Status MetadataReader::reals(std::string_view key, std::span<double> values) const {
  std::string_view text_value;
  ILP_TRY(text(key, text_value));
  Scanner in(text_value);
  bool good = true;
  for (std::size_t i = 0; good && i < values.size(); ++i) {
    if (i > 0) good = in.accept(' ');
    good = good && scan_real(in, values[i]);
  }
  if (!good || !in.done()) {
    return {StatusCode::parse_error, reinterpret_cast<const std::uint8_t*>(text_value.data()) - bytes_.data()};
  }
  return {};
}

}  // namespace ilp
