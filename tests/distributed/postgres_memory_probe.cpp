// The store on a server when the memory of PostgreSQL's library is exhausted: every request in turn finds none, then
// there is really none left. Each call ends with a Status, and what was committed is there afterwards. Runs with
// tests/distributed/with_postgres and has the flight's memory instead of a heap.
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "bsp/memory/flight_heap.hpp"
#include "cfg/limits.hpp"
#include "hal/store/postgres/postgres_store.hpp"

namespace {

using namespace ilp;

constexpr std::uint32_t image_bytes = 300'000;

PostgresStore store;
std::uint8_t image[image_bytes];
std::uint8_t answer[image_bytes];
char output_buffer[BUFSIZ];
int failures = 0;

void expect(bool condition, const char* what, std::uint64_t nth) {
  if (condition) return;
  std::printf("%llu: expected: %s\n", static_cast<unsigned long long>(nth), what);
  ++failures;
}

Status put_image(std::int64_t id) {
  FrameRecord frame{.id = id};
  frame.image.bytes = image_bytes;
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store, frame));
  ILP_TRY(write_blob<FrameRecord>(store, "image", id, 0, image));
  return transaction.commit();
}

bool is_whole(std::int64_t id) {
  std::memset(answer, 0, sizeof(answer));
  FrameRecord frame;
  return get(store, id, frame).ok() && read_blob<FrameRecord>(store, "image", id, 0, answer).ok() &&
         std::memcmp(answer, image, sizeof(image)) == 0;
}

/// All that a flight asks of it.
Status work(std::int64_t id) {
  ILP_TRY(put_image(id));
  RecordMask changed = 0;
  ILP_TRY(store.poll(changed));
  ILP_TRY(store.flush());
  store.wait(1);
  FrameRecord frame;
  ILP_TRY(last(store, frame));
  return read_blob<FrameRecord>(store, "image", frame.id, 0, answer);
}

void every_request_in_turn_finds_none(const char* conninfo) {
  int refused = 0;
  std::int64_t committed = 0;
  // Requests are counted from each opening of the gate, of which a call may have many: the first ones matter most.
  for (std::uint64_t nth = 1; nth <= 40; ++nth) {
    const auto id = static_cast<std::int64_t>(nth);
    set_heap_fault(nth);
    const Status status = work(id);
    set_heap_fault(0);
    refused += status.ok() ? 0 : 1;
    if (status.is(StatusCode::store_lost)) {
      expect(!store.connected(), "a lost connection is known to be lost", nth);
      expect(status.b == ENOMEM, "the reason is named: no memory", nth);
    }
    const Status again = store.connected() ? Status{} : store.reconnect();
    expect(again.ok(), "connected again", nth);
    expect(committed == 0 || is_whole(committed), "what was committed before is there", nth);
    expect(put_image(1000 + id).ok() && is_whole(1000 + id), "the store works again", nth);
    committed = 1000 + id;
  }
  expect(refused > 3, "some requests were refused", 0);
  for (std::uint64_t nth = 1; nth <= 60; ++nth) {
    store.close();
    set_heap_fault(nth);
    const Status status = store.open(conninfo, ~RecordMask{0});
    set_heap_fault(0);
    // libpq answers a connection for which it has no memory in several ways; none of them is a crash or a half-open
    // store.
    expect(status.ok() == store.connected(), "open and connected, or neither", nth);
  }
  if (!store.connected()) expect(store.open(conninfo, ~RecordMask{0}).ok(), "opened again", 0);
}

void an_image_that_does_not_fit_is_a_status() {
  void* held = nullptr;
  const HeapRegionReport region = heap_region_report(HeapRegion::postgres);
  expect(region.bytes == limits::postgres_heap_bytes, "the region has the size of the limit", 0);
  {
    const HeapGateScope scope(HeapRegion::postgres);
    for (std::size_t left = 100'000; held == nullptr && left < 10 * image_bytes; left += 100'000) {
      held = std::malloc(region.bytes - region.in_use - left);
    }
  }
  expect(held != nullptr, "most of the region is taken", 0);
  const Status status = put_image(5000);
  expect(status.is(StatusCode::store_lost) && status.b == ENOMEM, "no memory for the image", 0);
  {
    const HeapGateScope scope(HeapRegion::postgres);
    std::free(held);
  }
  expect(store.reconnect().ok() && put_image(5000).ok() && is_whole(5000), "there is memory again", 0);
}

}  // namespace

int main() {
  std::setvbuf(stdout, output_buffer, _IOFBF, sizeof(output_buffer));
  for (std::uint32_t k = 0; k < image_bytes; ++k) image[k] = static_cast<std::uint8_t>(k * k >> 5U);
  const char* const conninfo = std::getenv("ILP_POSTGRES");
  if (conninfo == nullptr) {
    std::printf("run it with tests/distributed/with_postgres\n");
    return 77;
  }
  expect(store.open(conninfo, ~RecordMask{0}).ok(), "opened", 0);
  seal_heap(HeapTrapMode::report);
  every_request_in_turn_finds_none(conninfo);
  an_image_that_does_not_fit_is_a_status();
  const HeapRegionReport region = heap_region_report(HeapRegion::postgres);
  store.close();
  std::printf("PostgreSQL: peak %zu of %zu bytes, %llu requests failed, %d failures\n", region.peak, region.bytes,
              static_cast<unsigned long long>(region.failed), failures);
  expect(heap_trap_count() == 0, "nothing was asked of a heap", heap_trap_count());
  return failures == 0 ? 0 : 1;
}
