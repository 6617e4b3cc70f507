// Bounded text in fixed arrays.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilp {

/// Copies as much of `from` as fits, terminates the text, and fills the rest with zeros.
template <std::size_t N>
void copy_text(char (&to)[N], const char* from) {
  std::size_t i = 0;
  for (; from != nullptr && i + 1 < N && from[i] != 0; ++i) to[i] = from[i];
  for (; i < N; ++i) to[i] = 0;
}

/// The part of a path after its last slash.
[[nodiscard]] inline const char* base_name(const char* path) {
  const char* name = path;
  for (const char* c = path; c != nullptr && *c != 0; ++c) {
    if (*c == '/') name = c + 1;
  }
  return name;
}

/// A terminated text that grows by add(). Text that does not fit is cut, and overflow() becomes true.
template <std::size_t N>
class FixedText {
 public:
  FixedText& add(const char* text) {
    for (; text != nullptr && *text != 0; ++text) add(*text);
    return *this;
  }
  FixedText& add(char c) {
    if (size_ + 1 < N) {
      text_[size_++] = c;
    } else {
      overflow_ = true;
    }
    return *this;
  }
  /// Appends a decimal number with at least `digits` digits.
  FixedText& add(std::int64_t value, int digits = 1) {
    char reversed[24];
    int n = 0;
    std::uint64_t rest = value < 0 ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
    while ((rest != 0 || n < digits) && n < 20) {
      reversed[n++] = static_cast<char>('0' + rest % 10);
      rest /= 10;
    }
    if (value < 0) add('-');
    while (n > 0) add(reversed[--n]);
    return *this;
  }
  void clear() {
    while (size_ > 0) text_[--size_] = 0;
    overflow_ = false;
  }
  [[nodiscard]] const char* c_str() const { return text_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool overflow() const { return overflow_; }

 private:
  char text_[N] = {};
  std::size_t size_ = 0;
  bool overflow_ = false;
};

}  // namespace ilp
