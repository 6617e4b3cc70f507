// Time of the worst NAKs that a sender can receive: 250 gaps that overlap 256 held ones, ascending and descending. A
// step takes at most 128 PDUs.
#include <benchmark/benchmark.h>

#include <vector>

#include "fsw/packets/cfdp_sender.hpp"

namespace ilp::cfdp {
namespace {

void worst_nak(benchmark::State& state) {
  SendOrder order{.file_bytes = 100'000};
  std::vector<Segment> held;
  for (std::uint32_t i = 0; i < limits::max_file_gaps; ++i) held.push_back({200 * i, 200 * i + 100});
  std::vector<std::uint8_t> octets(std::size_t{250} * 8);
  std::size_t size = 0;
  for (std::uint64_t i = 0; i < 250; ++i) {
    const std::uint64_t at = state.range(0) != 0 ? 249 - i : i;
    size += write_gap(order.header, {200 * at + 50, 200 * at + 150}, octets.data() + size);
  }
  Pdu nak;
  nak.kind = PduKind::nak;
  nak.header = order.header;
  nak.nak.gaps = std::span<const std::uint8_t>(octets).first(size);
  Sender sender;
  sender.resume(order, {}, order.file_bytes, true, held);
  for (auto _ : state) sender.receive(nak, 0);
}
BENCHMARK(worst_nak)->ArgName("descending")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace ilp::cfdp

BENCHMARK_MAIN();
