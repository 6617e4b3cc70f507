#include "sim/ground/intake/result_cache.hpp"

namespace ilp::intake {

std::optional<std::vector<std::uint8_t>> NotedResults::result(std::uint64_t digest) {
  std::optional<std::vector<std::uint8_t>> found = cache_.result(digest);
  const std::lock_guard lock(mutex_);
  if (found) noted_.insert(digest);
  return found;
}

void NotedResults::put_result(std::uint64_t digest, const std::vector<std::uint8_t>& bytes) {
  cache_.put_result(digest, bytes);
  const std::lock_guard lock(mutex_);
  noted_.insert(digest);
}

std::optional<std::vector<std::uint8_t>> MemoryResultCache::result(std::uint64_t digest) {
  const std::lock_guard lock(mutex_);
  const auto found = results_.find(digest);
  return found == results_.end() ? std::nullopt : std::optional(found->second);
}

void MemoryResultCache::put_result(std::uint64_t digest, const std::vector<std::uint8_t>& bytes) {
  const std::lock_guard lock(mutex_);
  results_[digest] = bytes;
}

}  // namespace ilp::intake
