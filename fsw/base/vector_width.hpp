// Compiles selected code also for wider vectors than every processor of the architecture has, and calls the version
// that the present processor can run.
#pragma once

#include <cstdint>

namespace ilp {

enum class VectorWidth : std::uint8_t { bytes16, bytes32 };

/// The widest vectors of this processor: 32 bytes with AVX2 on x86-64, otherwise 16.
[[nodiscard]] VectorWidth widest_vectors();
/// The width in use: widest_vectors(), unless a test has set another one.
[[nodiscard]] VectorWidth vectors_in_use();
/// Sets the width in use, for tests that compare the results of both widths. The processor must have such vectors.
void use_vectors(VectorWidth width);

#if defined(__x86_64__) && !defined(__AVX2__)
/// Calls `work()`. The compiler inlines into this function all calls of `work` whose code it sees, and compiles them
/// for vectors of 32 bytes. Other functions are called as they are.
template <typename Work>
[[gnu::target("avx2"), gnu::flatten, gnu::noinline]] void run_with_32_bytes(const Work& work) {
  work();
}
template <typename Work>
[[gnu::flatten, gnu::noinline]] void run_with_16_bytes(const Work& work) {
  work();
}
/// Calls `work()`, compiled for the width in use. The result must not depend on the width: `work` computes with
/// integers, or with floating-point operations on single elements, which the compiler does not contract or reorder.
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

/// A width as a type, for code whose data layout depends on the width.
template <VectorWidth width>
struct KnownWidth {
  static constexpr bool is_wide = width == VectorWidth::bytes32;
};

/// Calls `work(KnownWidth<...>())` with the width in use. The code of `work` may depend on the width; its result must
/// not.
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
