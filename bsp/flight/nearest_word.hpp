// Finds the word among several that is spelled most like a given one.
#pragma once

#include <cstddef>

namespace ilp {

/// Candidates are compared by their edit distance: the smallest number of letters to insert, remove or replace.
class NearestWord {
 public:
  /// `word` and the candidates outlive this object.
  explicit NearestWord(const char* word) : word_(word) {}
  void offer(const char* candidate);
  /// The nearest candidate, the first one of several. Null if the edit distance exceeds half of the letters of every
  /// candidate.
  [[nodiscard]] const char* found() const { return found_; }

  static constexpr std::size_t max_letters = 40;  ///< longer words and candidates never match

 private:
  const char* word_;
  const char* found_ = nullptr;
  std::size_t distance_ = max_letters + 1;
};

}  // namespace ilp
