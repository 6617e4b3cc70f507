// Which of several words is spelled most like a given one.
#pragma once

#include <cstddef>

namespace ilp {

/// Offers are compared by their edit distance: the fewest letters to insert, remove or replace.
class NearestWord {
 public:
  /// `word` has to live as long as this object.
  explicit NearestWord(const char* word) : word_(word) {}
  void offer(const char* candidate);
  /// The first of the nearest offers; null when more than half of its letters would change.
  [[nodiscard]] const char* found() const { return found_; }

  static constexpr std::size_t max_letters = 40;  ///< a longer word, or a longer offer, is near to nothing

 private:
  const char* word_;
  const char* found_ = nullptr;
  std::size_t distance_ = max_letters + 1;
};

}  // namespace ilp
