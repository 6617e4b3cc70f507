// Prints the cost and the results of a flight from its database: figures DATABASE

#include <cinttypes>
#include <cstdio>

#include "bsp/flight/status_text.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "hal/store/store.hpp"

namespace {

using namespace ilp;

int print(SqliteStore& store) {
  ComponentRecord component;
  for (std::int64_t id = 0; next(store, id, component).ok(); id = component.id) {
    std::printf("component %s steps %u busy_ns %" PRId64 " longest_ns %" PRId64 " overruns %u\n", component.name,
                component.steps, component.busy_ns, component.longest_ns, component.overruns);
  }
  ProductRecord product;
  for (std::int64_t id = 0; next(store, id, product).ok(); id = product.id) {
    std::printf("product %" PRId64 " keyframe %" PRId64 " bytes %u crc32 %08x\n", product.id, product.keyframe_id,
                product.bytes, product.crc32);
  }
  std::int64_t frames = 0, keyframes = 0;
  const bool counted = store.count(record_info(RecordType::frame), frames).ok() &&
                       store.count(record_info(RecordType::keyframe), keyframes).ok();
  std::printf("frames %" PRId64 " keyframes %" PRId64 "\n", frames, keyframes);
  return counted ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::printf("usage: figures DATABASE\n");
    return 2;
  }
  static SqliteStore store;
  const Status status = store.open_read_only(argv[1]);
  if (!status.ok()) {
    std::printf("figures: %s: %s\n", argv[1], status_words(status).c_str());
    return 1;
  }
  return print(store);
}
