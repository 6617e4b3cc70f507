#include "bsp/flight/nearest_word.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace ilp {
namespace {

/// Two rows of the table of R. A. Wagner and M. J. Fischer, "The String-to-String Correction Problem", 1974.
std::size_t edit_distance(const char* a, std::size_t a_letters, const char* b, std::size_t b_letters) {
  std::array<std::size_t, NearestWord::max_letters + 1> above{}, row{};
  for (std::size_t j = 0; j <= b_letters; ++j) above[j] = j;
  for (std::size_t i = 1; i <= a_letters; ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b_letters; ++j) {
      const std::size_t replaced = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({replaced, above[j] + 1, row[j - 1] + 1});
    }
    above = row;
  }
  return above[b_letters];
}

}  // namespace

void NearestWord::offer(const char* candidate) {
  const std::size_t letters = std::strlen(word_), offered = std::strlen(candidate);
  if (letters > max_letters || offered > max_letters) return;
  const std::size_t distance = edit_distance(word_, letters, candidate, offered);
  if (distance >= distance_ || 2 * distance > offered) return;
  distance_ = distance;
  found_ = candidate;
}

}  // namespace ilp
