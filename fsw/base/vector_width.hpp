// The one place where code is compiled for wider vectors than every processor of its architecture has.
#pragma once

#include <cstdint>

namespace ilp {

enum class VectorWidth : std::uint8_t { bytes16, bytes32 };

/// The widest vectors of this processor: 32 bytes with AVX2 on x86-64, otherwise 16.
[[nodiscard]] VectorWidth widest_vectors();
/// The width in use: the widest, unless a test has chosen another one.
[[nodiscard]] VectorWidth vectors_in_use();
/// For tests, which compare the results of both widths. The processor must have these vectors.
void use_vectors(VectorWidth width);

#if defined(__x86_64__) && !defined(__AVX2__)
/// The compiler puts everything that `work` calls, and can see, into this function, and so compiles it for these
/// vectors. What it cannot see is called as usual.
template <typename Work>
[[gnu::target("avx2"), gnu::flatten, gnu::noinline]] void run_with_32_bytes(const Work& work) {
  work();
}
template <typename Work>
[[gnu::flatten, gnu::noinline]] void run_with_16_bytes(const Work& work) {
  work();
}
/// Calls `work()`, compiled for the vectors in use. The result must not depend on their width: it consists of integers,
/// or of floating-point operations on one element at a time, which no compiler may contract or reorder here.
template <typename Work>
void with_widest_vectors(const Work& work) {
  if (vectors_in_use() == VectorWidth::bytes32) {
    run_with_32_bytes(work);
  } else {
    run_with_16_bytes(work);
  }
}
#else
template <typename Work>
void with_widest_vectors(const Work& work) {
  work();
}
#endif

/// A width as a type, for code that lays its data out for it.
template <VectorWidth width>
struct KnownWidth {
  static constexpr bool is_wide = width == VectorWidth::bytes32;
};

/// As with_widest_vectors(), for work whose instructions differ between the widths, but not its result: calls
/// `work(KnownWidth<...>())`.
template <typename Work>
void with_known_vectors(const Work& work) {
#if defined(__x86_64__) && !defined(__AVX2__)
  if (vectors_in_use() == VectorWidth::bytes32) {
    run_with_32_bytes([&] { work(KnownWidth<VectorWidth::bytes32>()); });
  } else {
    run_with_16_bytes([&] { work(KnownWidth<VectorWidth::bytes16>()); });
  }
#elif defined(__AVX2__)
  work(KnownWidth<VectorWidth::bytes32>());
#else
  work(KnownWidth<VectorWidth::bytes16>());
#endif
}

}  // namespace ilp
