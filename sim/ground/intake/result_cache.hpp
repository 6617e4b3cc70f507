// Caches from one run to the next for results that depend on their inputs only.
#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "sim/host/digest.hpp"

namespace ilp::intake {

/// A cache of results. The key of a result is the digest of the computation's name, its version and all its inputs
/// (InputDigest). All functions may be called from several threads at once.
class ResultCache {
 public:
  virtual ~ResultCache() = default;
  /// The bytes of a result; none if the cache does not have it.
  [[nodiscard]] virtual std::optional<std::vector<std::uint8_t>> result(std::uint64_t digest) = 0;
  virtual void put_result(std::uint64_t digest, const std::vector<std::uint8_t>& bytes) = 0;
};

/// Passes calls on to another cache, and notes which results were found or put.
class NotedResults : public ResultCache {
 public:
  explicit NotedResults(ResultCache& cache) : cache_(cache) {}
  std::optional<std::vector<std::uint8_t>> result(std::uint64_t digest) override;
  void put_result(std::uint64_t digest, const std::vector<std::uint8_t>& bytes) override;
  [[nodiscard]] const std::set<std::uint64_t>& noted() const { return noted_; }

 private:
  ResultCache& cache_;
  std::mutex mutex_;
  std::set<std::uint64_t> noted_;
};

class MemoryResultCache : public ResultCache {
 public:
  std::optional<std::vector<std::uint8_t>> result(std::uint64_t digest) override;
  void put_result(std::uint64_t digest, const std::vector<std::uint8_t>& bytes) override;
  [[nodiscard]] std::size_t size() const { return results_.size(); }

 private:
  std::mutex mutex_;
  std::map<std::uint64_t, std::vector<std::uint8_t>> results_;
};

/// Digest of a computation's name and inputs; it depends on their order.
class InputDigest {
 public:
  /// `computation`: name with version.
  explicit InputDigest(std::string_view computation) : state_(host::digest(computation)) {}

  InputDigest& add(std::span<const std::uint8_t> bytes) {
    state_ = host::digest({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, state_);
    return *this;
  }
  template <typename T>
  InputDigest& add_value(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    return add({reinterpret_cast<const std::uint8_t*>(&value), sizeof(value)});
  }
  [[nodiscard]] std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_;
};

/// Appends a list to `bytes`: the number of elements (32 bits), and the elements as they are in memory.
template <typename List>
void append(const List& list, std::vector<std::uint8_t>& bytes) {
  static_assert(std::is_trivially_copyable_v<typename List::value_type>);
  const auto count = static_cast<std::uint32_t>(list.size());
  const auto* counted = reinterpret_cast<const std::uint8_t*>(&count);
  bytes.insert(bytes.end(), counted, counted + sizeof(count));
  const auto* elements = reinterpret_cast<const std::uint8_t*>(list.data());
  bytes.insert(bytes.end(), elements, elements + list.size() * sizeof(typename List::value_type));
}

/// Reads the next list that append() wrote, and removes it from the front of `bytes`. Returns false, with an empty
/// list, if `bytes` is too short or the list exceeds the container's capacity.
template <typename List>
[[nodiscard]] bool take(std::span<const std::uint8_t>& bytes, List& list) {
  std::uint32_t count = 0;
  list.clear();
  if (bytes.size() < sizeof(count)) return false;
  std::memcpy(&count, bytes.data(), sizeof(count));
  bytes = bytes.subspan(sizeof(count));
  constexpr std::size_t size = sizeof(typename List::value_type);
  if (bytes.size() / size < count) return false;
  if constexpr (std::is_void_v<decltype(list.resize(count))>) {
    list.resize(count);
  } else if (!list.resize(count)) {
    return false;
  }
  if (count > 0) std::memcpy(list.data(), bytes.data(), count * size);
  bytes = bytes.subspan(count * size);
  return true;
}

}  // namespace ilp::intake
