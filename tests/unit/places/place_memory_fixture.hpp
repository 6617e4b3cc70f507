// The memory of places on a store in memory, over analytic ground.
#pragma once

#include <memory>
#include <vector>

#include "fsw/places/place_memory.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/places/place_flight.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp::test {

class PlaceMemoryTest : public ComponentTest, protected PlaceFlight {
 protected:
  PlaceMemoryTest() : PlaceFlight(store) { write_camera(); }

  template <typename Record>
  void erase_record(std::int64_t id) {
    in_transaction(store, [&] { ASSERT_TRUE(store.erase(record_info<Record>(), id).ok()); });
  }
  /// A flight of its own begins.
  void begin_again() {
    std::destroy_at(&store);
    std::construct_at(&store, region);
    write_camera();
  }

  std::unique_ptr<PlaceMemory> memory() {
    auto stage = std::make_unique<PlaceMemory>(store, mission, test::step_memory<PlaceMemory>());
    EXPECT_TRUE(restored(stage->restore()));
    return stage;
  }
  std::vector<LinkRecord> links() { return records_of<LinkRecord>(store); }
  std::vector<std::uint8_t> mask_of(std::int64_t id) {
    const MaskRecord record = read<MaskRecord>(id);
    std::vector<std::uint8_t> coded(record.code.bytes);
    EXPECT_TRUE(read_blob<MaskRecord>(store, "code", id, 0, coded).ok());
    std::vector<std::uint8_t> mask(static_cast<std::size_t>(record.width * record.height));
    EXPECT_TRUE(decode_mask(coded.data(), coded.size(), {mask.data(), record.width, record.height}).ok());
    return mask;
  }
  std::uint32_t new_pixels(std::int64_t id) {
    std::uint32_t count = 0;
    for (const std::uint8_t pixel : mask_of(id)) count += pixel != 0 ? 1 : 0;
    return count;
  }
};

}  // namespace ilp::test
