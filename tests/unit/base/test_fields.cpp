#include "fsw/base/fields.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ilp {
// Named, because the compiler looks at the fields of structs with linkage only.
namespace fields_test {

enum class Colour : std::uint8_t { red };
struct Inner {
  std::int32_t number = 0;
  double line[4] = {};
};
class Closed {
 public:
  Closed() = default;

 private:
  [[maybe_unused]] std::int32_t secret_ = 0;
};
struct All {
  double plane[9] = {1};
  std::int64_t id = 0;
  Inner inner;
  std::array<double, 5> array{};
  FixedVector<Inner, 3> vector;
  char name[32] = {};
  bool yes = false;
  Colour colour = Colour::red;
  Closed closed;
};

TEST(Fields, AreNamedInTheirOrder) {
  std::vector<std::string> names;
  std::vector<std::size_t> sizes;
  for_each_field<All>([&]<typename Field>(std::string_view name) {
    names.emplace_back(name);
    sizes.push_back(sizeof(Field));
  });
  EXPECT_EQ(names,
            (std::vector<std::string>{"plane", "id", "inner", "array", "vector", "name", "yes", "colour", "closed"}));
  EXPECT_EQ(sizes, (std::vector<std::size_t>{sizeof(All::plane), sizeof(All::id), sizeof(All::inner),
                                             sizeof(All::array), sizeof(All::vector), sizeof(All::name), 1, 1, 4}));
}

struct Before {
  std::int64_t first = 0;
  std::int64_t second = 0;
  bool flag = false;
};

struct LayoutSame {
  std::int64_t first = 7;
  std::int64_t second = 0;
  bool flag = true;
};
struct LayoutSwapped {
  std::int64_t second = 0;
  std::int64_t first = 0;
  bool flag = false;
};
struct LayoutRenamed {
  std::int64_t first = 0;
  std::int64_t last = 0;
  bool flag = false;
};
struct LayoutReal {
  std::int64_t first = 0;
  double second = 0;
  bool flag = false;
};
struct LayoutUnsigned {
  std::int64_t first = 0;
  std::uint64_t second = 0;
  bool flag = false;
};
struct LayoutMore {
  std::int64_t first = 0;
  std::int64_t second = 0;
  bool flag = false, other = false;
};
struct LayoutHalved {
  std::int64_t first = 0;
  std::int32_t second[2] = {};
  bool flag = false;
};

TEST(Fields, ADigestTellsEveryChangeOfALayoutOfEqualSize) {
  EXPECT_EQ(layout_digest<Before>(), layout_digest<LayoutSame>()) << "values and the name of the struct are no layout";
  for (const std::uint64_t other :
       {layout_digest<LayoutSwapped>(), layout_digest<LayoutRenamed>(), layout_digest<LayoutReal>(),
        layout_digest<LayoutUnsigned>(), layout_digest<LayoutMore>(), layout_digest<LayoutHalved>()}) {
    EXPECT_NE(layout_digest<Before>(), other);
  }
}

struct WholeOf {
  FixedVector<Before, 2> list;
};
struct WholeOfLonger {
  FixedVector<Before, 3> list;
};
struct WholeRenamed {
  std::int64_t first = 0;
  std::int64_t last = 0;
  bool flag = false;
};
struct WholeOfRenamed {
  FixedVector<WholeRenamed, 2> list;
};

TEST(Fields, ADigestSeesWhatLiesWithin) {
  EXPECT_NE(layout_digest<WholeOf>(), layout_digest<WholeOfLonger>());
  EXPECT_NE(layout_digest<WholeOf>(), layout_digest<WholeOfRenamed>());
}

TEST(Fields, ADigestIsTheSameForEveryCompilerAndProcessor) {
  // As a script computes it from the names, kinds and sizes.
  EXPECT_EQ(layout_digest<Before>(), 0x563043228ECB11DAU);
}

struct PointingDeep {
  std::array<Inner, 2> inner{};
  struct {
    FixedVector<const char*, 2> texts;
  } list;
};

TEST(Fields, PointersAreFoundAtAnyDepth) {
  EXPECT_FALSE(has_pointers<All>());
  EXPECT_TRUE(has_pointers<PointingDeep>());
}

}  // namespace fields_test
}  // namespace ilp
