// A vector with a fixed capacity and inline storage, for trivially copyable elements.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "fsw/base/status.hpp"

namespace ilp {

/// The elements are stored inside the object, so that a struct of FixedVectors is trivially copyable and can be a
/// checkpoint. Indices are not checked. A call that would exceed the capacity returns false and changes nothing. size()
/// never exceeds the capacity, even if a bit of the stored size is flipped.
template <typename T, std::size_t Capacity>
class FixedVector {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  using value_type = T;

  [[nodiscard]] static constexpr std::size_t capacity() { return Capacity; }
  [[nodiscard]] std::size_t size() const { return size_ <= Capacity ? size_ : Capacity; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] bool full() const { return size_ >= Capacity; }

  [[nodiscard]] bool push_back(const T& value) {
    if (full()) return false;
    items_[size_++] = value;
    return true;
  }
  void pop_back() {
    if (!empty()) size_ = static_cast<std::uint32_t>(size() - 1);
  }
  /// Removes an element; the later ones move forward by one. Does nothing if there is no element `index`.
  void erase(std::size_t index) {
    for (std::size_t i = index + 1; i < size(); ++i) items_[i - 1] = items_[i];
    if (index < size()) pop_back();
  }
  void clear() { size_ = 0; }
  /// New elements are value-initialised. Returns false and changes nothing when `size` exceeds the capacity.
  [[nodiscard]] bool resize(std::size_t size) {
    if (size > Capacity) return false;
    for (std::size_t i = this->size(); i < size; ++i) items_[i] = T{};
    size_ = static_cast<std::uint32_t>(size);
    return true;
  }

  T& operator[](std::size_t i) { return items_[i]; }
  const T& operator[](std::size_t i) const { return items_[i]; }
  T& back() { return items_[size() - 1]; }
  const T& back() const { return items_[size() - 1]; }
  T* data() { return items_.data(); }
  const T* data() const { return items_.data(); }
  T* begin() { return data(); }
  T* end() { return data() + size(); }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size(); }

 private:
  std::array<T, Capacity> items_{};
  std::uint32_t size_ = 0;
};

}  // namespace ilp
