// The octets between the fields are cleared, and no other ones.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <vector>

#include "fsw/base/fields.hpp"

namespace ilp {
// Named, because the compiler looks at the fields of structs with linkage only.
namespace padding_test {

struct Place {
  std::int64_t id;
  std::int64_t time_ns;
};
struct Part {
  std::int32_t number;
  double values[3];
  bool last;
};
struct State {
  std::int64_t first;
  FixedVector<Place, 40> places;
  FixedVector<std::uint8_t, 5> octets;
  Part parts[2];
  std::array<Part, 1> more;
  char name[5];
  bool ended;
};

template <typename T>
std::vector<std::size_t> cleared_octets() {
  T object;
  std::memset(static_cast<void*>(&object), 0xFF, sizeof(object));
  clear_padding(object);
  std::vector<std::uint8_t> bytes(sizeof(object));
  std::memcpy(bytes.data(), &object, sizeof(object));
  std::vector<std::size_t> cleared;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (bytes[i] != 0xFF) cleared.push_back(i);
  }
  return cleared;
}

TEST(Padding, IsClearedAtAnyDepthAndNothingElseIs) {
  std::vector<std::size_t> expected;
  const auto pad = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) expected.push_back(i);
  };
  pad(8 + 640 + 4, 656);  // behind the size of `places`
  pad(656 + 5, 656 + 8);  // between the octets and their number
  pad(656 + 12, 672);     // before `parts`
  for (std::size_t part = 672; part < 672 + 3 * 40; part += 40) {
    pad(part + 4, part + 8);
    pad(part + 33, part + 40);
  }
  pad(792 + 6, 800);
  EXPECT_EQ(sizeof(State), 800U);
  EXPECT_EQ(cleared_octets<State>(), expected);
  EXPECT_TRUE(cleared_octets<Place>().empty());
}

}  // namespace padding_test
}  // namespace ilp
