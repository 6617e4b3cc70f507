// Time of the store's calls: SQLite, and PostgreSQL where the environment names a server (ILP_POSTGRES, as
// tests/distributed/with_postgres does). The database of SQLite lies in the folder of ILP_BENCH_FOLDER, or in /tmp.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "fsw/records/records.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#ifdef ILP_POSTGRES
#include "hal/store/postgres/postgres_store.hpp"
#endif

namespace ilp {
namespace {

constexpr std::uint32_t image_bytes = 300'000;

std::string environment(const char* name, const char* otherwise) {
  const char* const value = std::getenv(name);
  return value != nullptr ? value : otherwise;
}

/// What is measured is void without it.
void must(const Status& status) {
  if (status.ok()) return;
  std::fprintf(stderr, "bench_store: %s (%lld, %lld)\n", status_name(status.code), static_cast<long long>(status.a),
               static_cast<long long>(status.b));
  std::exit(1);
}

struct Sqlite {
  static constexpr const char* name = "SQLite";
  std::string path;
  std::unique_ptr<SqliteStore> store = std::make_unique<SqliteStore>();

  Sqlite() {
    static int number = 0;
    path = environment("ILP_BENCH_FOLDER", "/tmp") + "/bench-" + std::to_string(getpid()) + "-" +
           std::to_string(++number) + ".db";
    must(store->open(path.c_str()));
  }
  /// Another connection to the same store.
  explicit Sqlite(const Sqlite& other) { must(store->open(other.path.c_str())); }
  ~Sqlite() {
    store.reset();
    if (path.empty()) return;
    for (const char* suffix : {"", "-wal", "-shm", "-wal-sync"}) std::filesystem::remove(path + suffix);
  }
  void wait() const { usleep(1000); }
};

#ifdef ILP_POSTGRES
struct Postgres {
  static constexpr const char* name = "PostgreSQL";
  std::unique_ptr<PostgresStore> store = std::make_unique<PostgresStore>();

  Postgres() {
    must(store->open(environment("ILP_POSTGRES", "").c_str(), ~RecordMask{0}));
    for (const RecordType type : {RecordType::frame, RecordType::keyframe, RecordType::pose}) empty(record_info(type));
  }
  explicit Postgres(const Postgres&) { must(store->open(environment("ILP_POSTGRES", "").c_str(), ~RecordMask{0})); }
  void wait() const { store->wait(1000); }

 private:
  void empty(const RecordInfo& info) {
    alignas(8) std::uint8_t record[limits::max_record_bytes];
    must(store->begin());
    while (store->last(info, record).ok()) must(store->erase(info, *reinterpret_cast<const std::int64_t*>(record)));
    must(store->commit());
  }
};
#endif

template <typename Record>
void put_now(Store& store, std::int64_t id) {
  Record record;
  record.id = id;
  must(store.begin());
  must(put(store, record));
  must(store.commit());
}

template <typename Backend>
void commit(benchmark::State& state) {
  Backend backend;
  std::int64_t id = 0;
  for (auto _ : state) put_now<PoseRecord>(*backend.store, ++id);
}

/// Two commits, two wake-ups: a keyframe is answered by a pose.
template <typename Backend>
void there_and_back(benchmark::State& state) {
  Backend here;
  Backend there(static_cast<const Backend&>(here));
  std::atomic<bool> ended = false;
  std::thread other([&] {
    KeyframeRecord keyframe;
    RecordMask changed = 0;
    while (!ended) {
      must(there.store->poll(changed));
      bool any = false;
      while (next(*there.store, keyframe.id, keyframe).ok()) {
        put_now<PoseRecord>(*there.store, keyframe.id);
        any = true;
      }
      if (!any && !ended) there.wait();
    }
  });
  std::int64_t id = 0;
  for (auto _ : state) {
    put_now<KeyframeRecord>(*here.store, ++id);
    PoseRecord pose;
    RecordMask changed = 0;
    while (!get(*here.store, id, pose).ok()) {
      here.wait();
      must(here.store->poll(changed));
    }
  }
  ended = true;
  put_now<KeyframeRecord>(*here.store, ++id);
  other.join();
}

void put_image(Store& store, std::int64_t id, const std::vector<std::uint8_t>& image) {
  FrameRecord frame{.id = id};
  frame.image.bytes = image_bytes;
  must(store.begin());
  must(put(store, frame));
  must(write_blob<FrameRecord>(store, "image", id, 0, image));
  must(store.commit());
}

std::vector<std::uint8_t> make_image(std::int64_t id) {
  std::vector<std::uint8_t> image(image_bytes);
  for (std::size_t i = 0; i < image.size(); ++i) {
    image[i] = static_cast<std::uint8_t>((i * 2654435761U >> 13U) ^ static_cast<std::size_t>(id));
  }
  return image;
}

template <typename Backend>
void write_image(benchmark::State& state) {
  Backend backend;
  const std::vector<std::uint8_t> image = make_image(1);
  std::int64_t id = 0;
  // Twenty places, as in a flight whose storage manager abandons images.
  for (auto _ : state) put_image(*backend.store, ++id % 20, image);
}

/// In pieces of the given size.
template <typename Backend>
void read_image(benchmark::State& state) {
  Backend backend;
  for (std::int64_t id = 0; id < 20; ++id) put_image(*backend.store, id, make_image(id));
  const auto patch = static_cast<std::size_t>(state.range(0));
  std::vector<std::uint8_t> image(image_bytes);
  std::int64_t id = 0;
  for (auto _ : state) {
    id = (id + 1) % 20;
    for (std::size_t at = 0; at < image_bytes; at += patch) {
      const std::size_t size = std::min(patch, image_bytes - at);
      must(read_blob<FrameRecord>(*backend.store, "image", id, at, std::span(image).subspan(at, size)));
    }
  }
}

/// Time per record. Before each walk another record of the table changes.
template <typename Backend>
void walk(benchmark::State& state) {
  Backend backend;
  constexpr int records = 1000;
  must(backend.store->begin());
  for (int id = 1; id <= records; ++id) must(put(*backend.store, PoseRecord{.id = id}));
  must(backend.store->commit());
  Backend other(static_cast<const Backend&>(backend));
  RecordMask changed = 0;
  for (auto _ : state) {
    state.PauseTiming();
    put_now<PoseRecord>(*other.store, records);
    must(backend.store->poll(changed));
    state.ResumeTiming();
    PoseRecord pose;
    while (next(*backend.store, pose.id, pose).ok()) {
    }
  }
  state.SetItemsProcessed(state.iterations() * records);
}

template <typename Backend>
void add_benchmarks() {
  const auto name = [](const char* what) { return std::string(what) + "/" + Backend::name; };
  using benchmark::RegisterBenchmark;
  RegisterBenchmark(name("commit").c_str(), commit<Backend>)->Unit(benchmark::kMicrosecond)->UseRealTime();
  RegisterBenchmark(name("there_and_back").c_str(), there_and_back<Backend>)
      ->Unit(benchmark::kMicrosecond)
      ->UseRealTime();
  RegisterBenchmark(name("write_image").c_str(), write_image<Backend>)->Unit(benchmark::kMicrosecond)->UseRealTime();
  RegisterBenchmark(name("read_image").c_str(), read_image<Backend>)
      ->Unit(benchmark::kMicrosecond)
      ->Arg(image_bytes)
      ->Arg(4096)
      ->UseRealTime();
  RegisterBenchmark(name("walk").c_str(), walk<Backend>)->Unit(benchmark::kMicrosecond)->UseRealTime();
}

}  // namespace
}  // namespace ilp

int main(int argc, char** argv) {
  ilp::add_benchmarks<ilp::Sqlite>();
#ifdef ILP_POSTGRES
  if (std::getenv("ILP_POSTGRES") != nullptr) ilp::add_benchmarks<ilp::Postgres>();
#endif
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
