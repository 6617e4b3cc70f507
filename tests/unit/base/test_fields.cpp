#include "fsw/base/fields.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ilp {
namespace {

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

TEST(Fields, ADigestTellsEveryChangeOfALayoutOfEqualSize) {
  struct Same {
    std::int64_t first = 7;
    std::int64_t second = 0;
    bool flag = true;
  };
  EXPECT_EQ(layout_digest<Before>(), layout_digest<Same>()) << "values and the name of the struct are no layout";
  struct Swapped {
    std::int64_t second = 0;
    std::int64_t first = 0;
    bool flag = false;
  };
  struct Renamed {
    std::int64_t first = 0;
    std::int64_t last = 0;
    bool flag = false;
  };
  struct Real {
    std::int64_t first = 0;
    double second = 0;
    bool flag = false;
  };
  struct Unsigned {
    std::int64_t first = 0;
    std::uint64_t second = 0;
    bool flag = false;
  };
  struct More {
    std::int64_t first = 0;
    std::int64_t second = 0;
    bool flag = false, other = false;
  };
  struct Halved {
    std::int64_t first = 0;
    std::int32_t second[2] = {};
    bool flag = false;
  };
  for (const std::uint64_t other : {layout_digest<Swapped>(), layout_digest<Renamed>(), layout_digest<Real>(),
                                    layout_digest<Unsigned>(), layout_digest<More>(), layout_digest<Halved>()}) {
    EXPECT_NE(layout_digest<Before>(), other);
  }
}

TEST(Fields, ADigestSeesWhatLiesWithin) {
  struct Of {
    FixedVector<Before, 2> list;
  };
  struct OfLonger {
    FixedVector<Before, 3> list;
  };
  struct Renamed {
    std::int64_t first = 0;
    std::int64_t last = 0;
    bool flag = false;
  };
  struct OfRenamed {
    FixedVector<Renamed, 2> list;
  };
  EXPECT_NE(layout_digest<Of>(), layout_digest<OfLonger>());
  EXPECT_NE(layout_digest<Of>(), layout_digest<OfRenamed>());
}

TEST(Fields, ADigestIsTheSameForEveryCompilerAndProcessor) {
  // As a script computes it from the names, kinds and sizes.
  EXPECT_EQ(layout_digest<Before>(), 0x563043228ECB11DAU);
}

TEST(Fields, PointersAreFoundAtAnyDepth) {
  struct Deep {
    std::array<Inner, 2> inner{};
    struct {
      FixedVector<const char*, 2> texts;
    } list;
  };
  EXPECT_FALSE(has_pointers<All>());
  EXPECT_TRUE(has_pointers<Deep>());
}

}  // namespace
}  // namespace ilp
