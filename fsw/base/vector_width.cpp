#include "fsw/base/vector_width.hpp"

namespace ilp {
namespace {

// Zero until a test chooses, so that no code must run before main.
enum class Chosen : std::uint8_t { nothing, bytes16, bytes32 };
Chosen chosen = Chosen::nothing;

}  // namespace

VectorWidth widest_vectors() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") ? VectorWidth::bytes32 : VectorWidth::bytes16;
#else
  return VectorWidth::bytes16;
#endif
}

VectorWidth vectors_in_use() {
  if (chosen == Chosen::nothing) return widest_vectors();
  return chosen == Chosen::bytes32 ? VectorWidth::bytes32 : VectorWidth::bytes16;
}

void use_vectors(VectorWidth width) {
  chosen = width == VectorWidth::bytes32 ? Chosen::bytes32 : Chosen::bytes16;
}

}  // namespace ilp
