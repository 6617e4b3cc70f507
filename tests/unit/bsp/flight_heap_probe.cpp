// A flight binary in miniature, linked dynamically and statically: its heap is sealed, the codecs work inside their
// gates, everything else is caught. A plain program, because GoogleTest needs a heap. Exit status 0 when all holds.
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "bsp/memory/flight_heap.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "hal/camera/camera.hpp"
#include "hal/camera/jpeg/grey_jpeg.hpp"
#include "hal/posix/measured_stack.hpp"
#include "hal/worker/thread_worker.hpp"
#include "tests/support/jpeg_file.hpp"

namespace {

using namespace ilp;

constexpr std::int32_t width = limits::max_image_width;
constexpr std::int32_t height = limits::max_image_height;
constexpr std::size_t pixels = limits::max_image_pixels;
constexpr std::size_t file_bytes = 4 * pixels + 65536;

Jpeg2000Workspace workspace;
std::uint8_t image[pixels];
std::uint16_t depth[pixels];
std::uint8_t mask[pixels];
std::int32_t decoded[pixels];
std::uint8_t file[file_bytes];
std::uint8_t reference[file_bytes];
char output_buffer[4096];
alignas(stack_page_bytes) std::byte worker_stack[limits::worker_stack_bytes];

int failures = 0;

void expect(bool condition, const char* what) {
  std::printf("%s: %s\n", condition ? "ok" : "FAILED", what);
  if (!condition) ++failures;
}

// Noise is the worst case of a coder.
void fill_noise(int bits) {
  Rng rng(1);
  for (std::size_t i = 0; i < pixels; ++i) {
    const std::uint32_t value = rng.next() >> (32 - bits);
    image[i] = static_cast<std::uint8_t>(value);
    depth[i] = static_cast<std::uint16_t>(value);
    mask[i] = rng.below(3) == 0;
  }
}

void fill_scene() {
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(y * width + x);
      image[i] = static_cast<std::uint8_t>(x * y / 64 + (x ^ y) % 23);
      mask[i] = (x / 100 + y / 100) % 2 == 0;
    }
  }
}

Status encode_image(std::int32_t w, std::int32_t h, std::size_t ceiling, bool lossless, Jpeg2000Product& product) {
  Jpeg2000Params params{.max_bytes = ceiling, .layers = lossless ? 8 : 3, .lossless = lossless};
  return encode_jpeg2000(GrayView(image, w, h), MaskView(mask, w, h), params, {}, workspace, file, product);
}

Status encode_depth(RegionCoding coding, Jpeg2000Product& product) {
  Jpeg2000Params params{.max_bytes = sizeof(file), .region = coding, .layers = 8, .lossless = true};
  return encode_jpeg2000(ImageView<const std::uint16_t>(depth, width, height), 13, MaskView(mask, width, height),
                         params, {}, workspace, file, product);
}

void print_region(const char* what, HeapRegion region = HeapRegion::openjpeg) {
  const HeapRegionReport r = heap_region_report(region);
  std::printf("    after %s: peak %zu, high water %zu of %zu bytes, %llu requests\n", what, r.peak, r.high_water,
              r.bytes, static_cast<unsigned long long>(r.requests));
}

void codec_stays_in_its_region() {
  const std::uint64_t early_requests = heap_region_report(HeapRegion::early).requests;
  Jpeg2000Product product;
  fill_noise(8);
  expect(encode_image(width, height, sizeof(file), true, product).ok(), "8-bit noise, lossless, shifted region");
  print_region("8-bit noise with a shift");
  expect(decode_jpeg2000(std::span(file).first(product.bytes), false, {decoded, width, height}).ok(), "decoded");
  bool exact = true;
  for (std::size_t i = 0; i < pixels; ++i) exact = exact && decoded[i] == image[i];
  expect(exact, "exact");
  fill_noise(13);
  expect(encode_depth(RegionCoding::none, product).ok(), "13-bit noise, lossless");
  print_region("13-bit noise");
  expect(encode_depth(RegionCoding::drop_background, product).ok(), "13-bit noise, background dropped");
  for (std::size_t i = 0; i < pixels; ++i) depth[i] = static_cast<std::uint16_t>(4096 + (depth[i] >> 3U));
  const Status shifted = encode_depth(RegionCoding::shift, product);
  expect(shifted.ok(), "10 noisy bits of 13, shifted region");
  print_region("13 bits with a shift");
  expect(decode_jpeg2000(std::span(file).first(product.bytes), false, {decoded, width, height}).ok(), "decoded");
  print_region("its decoding");
  fill_scene();
  expect(encode_image(width, height, pixels / 16, false, product).ok(), "scene at 0.5 bit per pixel");
  expect(heap_region_report(HeapRegion::openjpeg).in_use == 0, "region empty after the calls");
  expect(heap_region_report(HeapRegion::openjpeg).failed == 0, "region never exhausted");
  expect(heap_region_report(HeapRegion::early).requests == early_requests, "no request outside the region");
  expect(heap_trap_count() == 0, "nothing trapped");
}

// OpenJPEG does not survive a failed request: the call must be abandoned, and the next one must not notice.
void exhaustion_is_a_status() {
  constexpr std::int32_t w = 120;
  constexpr std::int32_t h = 90;
  Jpeg2000Product product;
  fill_scene();
  const std::uint64_t before = heap_region_report(HeapRegion::openjpeg).requests;
  expect(encode_image(w, h, 1500, false, product).ok(), "small scene");
  const std::uint64_t requests = heap_region_report(HeapRegion::openjpeg).requests - before;
  std::memcpy(reference, file, product.bytes);
  const std::size_t reference_bytes = product.bytes;
  std::uint64_t tried = 0;
  std::uint64_t refused = 0;
  std::uint64_t same_after = 0;
  for (std::uint64_t k = 1; k <= requests / static_cast<unsigned>(product.encodings); k += k < 40 ? 1 : 17) {
    ++tried;
    set_heap_fault(k);
    if (encode_image(w, h, 1500, false, product).is(StatusCode::arena_exhausted)) ++refused;
    set_heap_fault(0);
    const Status status = encode_image(w, h, 1500, false, product);
    if (status.ok() && product.bytes == reference_bytes && std::memcmp(file, reference, reference_bytes) == 0)
      ++same_after;
  }
  std::printf("    %llu of about %llu requests failed in turn\n", static_cast<unsigned long long>(tried),
              static_cast<unsigned long long>(requests));
  expect(tried > 40 && refused == tried, "each failed request is a status");
  expect(same_after == tried, "the next encoding gives the same bytes");
  std::uint64_t decode_refused = 0;
  for (std::uint64_t k = 1; k <= 100; ++k) {
    set_heap_fault(k);
    if (!decode_jpeg2000(std::span(reference).first(reference_bytes), false, {decoded, w, h}).ok()) ++decode_refused;
  }
  set_heap_fault(0);
  expect(decode_refused == 100, "each failed request of a decoding is a status");
}

constexpr std::int32_t jpeg_width = limits::max_sensor_side;
constexpr std::int32_t jpeg_height = 128;

std::uint8_t jpeg_bytes[4 * jpeg_width * jpeg_height];
std::uint8_t jpeg_row[jpeg_width];
FrameImage jpeg_image;
RowReducer jpeg_rows;

/// The encoder is a host's, which needs a heap: that of the other codec.
std::span<const std::uint8_t> make_jpeg(const test::JpegKind& kind) {
  const HeapGateScope scope(HeapRegion::openjpeg);
  const auto luma = [](std::int32_t x, std::int32_t y) { return static_cast<std::uint8_t>(x * y / 64 + (x ^ y) % 23); };
  const std::vector<std::uint8_t> made = test::jpeg_file(jpeg_width, jpeg_height, luma, kind);
  std::memcpy(jpeg_bytes, made.data(), made.size());
  return std::span(jpeg_bytes).first(made.size());
}

std::uint32_t crc_of(MutableGrayView view) {
  return crc32({view.data, view.area()});
}

Status decode_jpeg(std::span<const std::uint8_t> bytes) {
  Reduction reduction;
  ILP_TRY(find_reduction(jpeg_width, jpeg_height, reduction));
  ILP_TRY(jpeg_image.resize(reduction.width, reduction.height));
  jpeg_rows.begin(reduction, jpeg_image.view());
  return decode_grey_jpeg(bytes, jpeg_width, jpeg_height, jpeg_row, jpeg_rows);
}

// The widest picture, in the samplings that need most rows at a time.
void jpeg_stays_in_its_region() {
  const std::uint64_t early_requests = heap_region_report(HeapRegion::early).requests;
  const std::uint64_t other_requests = heap_region_report(HeapRegion::openjpeg).requests;
  constexpr std::size_t samplings = 4;
  constexpr int factors[samplings][2] = {{1, 1}, {2, 1}, {2, 2}, {1, 4}};
  for (const auto& [horizontal, vertical] : factors) {
    const auto bytes = make_jpeg({.horizontal = horizontal, .vertical = vertical, .restart_rows = 1});
    expect(decode_jpeg(bytes).ok(), "a JPEG picture of the widest sensor");
    expect(!decode_jpeg(bytes.first(bytes.size() / 2)).ok(), "half of it is refused");
    print_region("it", HeapRegion::jpeg);
  }
  const auto progressive = make_jpeg({.progressive = true});
  expect(decode_jpeg(progressive).is(StatusCode::unsupported_format), "a progressive one is refused");
  expect(heap_region_report(HeapRegion::jpeg).in_use == 0, "region empty after the calls");
  expect(heap_region_report(HeapRegion::jpeg).failed == 0, "region never exhausted");
  expect(heap_region_report(HeapRegion::early).requests == early_requests, "no request outside the regions");
  expect(heap_region_report(HeapRegion::openjpeg).requests > other_requests, "the encoder used the other region");
  expect(heap_trap_count() == 0, "nothing trapped");
}

void exhaustion_of_jpeg_is_a_status() {
  const auto bytes = make_jpeg({.horizontal = 2, .vertical = 1});
  const std::uint64_t before = heap_region_report(HeapRegion::jpeg).requests;
  expect(decode_jpeg(bytes).ok(), "decoded");
  const std::uint64_t requests = heap_region_report(HeapRegion::jpeg).requests - before;
  const std::uint32_t crc = crc_of(jpeg_image.view());
  std::uint64_t refused = 0, same_after = 0;
  for (std::uint64_t k = 1; k <= requests; ++k) {
    set_heap_fault(k);
    if (decode_jpeg(bytes).is(StatusCode::arena_exhausted)) ++refused;
    set_heap_fault(0);
    if (decode_jpeg(bytes).ok() && crc_of(jpeg_image.view()) == crc) ++same_after;
  }
  std::printf("    %llu requests failed in turn\n", static_cast<unsigned long long>(requests));
  expect(requests > 3 && refused == requests, "each failed request is a status");
  expect(same_after == requests, "the next picture is decoded");
}

// Through a pointer, so that the compiler cannot drop the call.
void* (*volatile stray_malloc)(std::size_t) = std::malloc;
void* (*volatile stray_calloc)(std::size_t, std::size_t) = std::calloc;
void* (*volatile stray_realloc)(void*, std::size_t) = std::realloc;
char* (*volatile stray_strdup)(const char*) = strdup;

void strays_are_caught() {
  expect(stray_malloc(10) == nullptr, "stray malloc refused");
  expect(stray_calloc(10, 10) == nullptr, "stray calloc refused");
  expect(stray_realloc(nullptr, 10) == nullptr, "stray realloc refused");
  expect(stray_strdup("x") == nullptr, "malloc from inside the C library refused");
  void* aligned = nullptr;
  expect(posix_memalign(&aligned, 64, 10) != 0, "stray posix_memalign refused");
  expect(heap_trap_count() == 5, "five traps counted");
}

void strict_mode_aborts() {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    seal_heap(HeapTrapMode::strict);
    static_cast<void>(stray_malloc(1));
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  expect(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT, "strict mode aborts");
}

// The codec in another thread has its region, and the flight's thread has none meanwhile.
void the_region_is_of_its_thread(ThreadWorker& worker) {
  struct Coding {
    Status status;
    Jpeg2000Product product;
  };
  fill_scene();
  Coding here, beside;
  here.status = encode_image(width, height, pixels / 16, false, here.product);
  std::memcpy(reference, file, here.product.bytes);
  const std::uint64_t trapped = heap_trap_count();
  std::uint64_t refused = 0;
  const auto job = [](void* memory) {
    auto& coding = *static_cast<Coding*>(memory);
    coding.status = encode_image(width, height, pixels / 16, false, coding.product);
  };
  expect(worker.submit({job, &beside}).ok(), "the worker takes a job");
  while (worker.ask() == WorkerProgress::working) {
    if (refused < 3 && stray_malloc(10) == nullptr) ++refused;
  }
  expect(beside.status.ok() && beside.product.bytes == here.product.bytes &&
             std::memcmp(file, reference, here.product.bytes) == 0,
         "the same bytes in another thread");
  expect(refused > 0 && heap_trap_count() == trapped + refused, "requests of this thread are refused meanwhile");
  expect(heap_region_report(HeapRegion::openjpeg).in_use == 0, "region empty after the job");
  expect(worker.stop(), "the worker ends");
}

// A connection to a server lives in its region from call to call.
void memory_of_the_server_is_kept(void* before_sealing) {
  if (heap_region_report(HeapRegion::postgres).bytes < 65536) return;
  char* kept = nullptr;
  char* moved = nullptr;
  {
    const HeapGateScope scope(HeapRegion::postgres);
    kept = static_cast<char*>(stray_malloc(100));
    moved = static_cast<char*>(stray_realloc(before_sealing, 200));
  }
  expect(kept != nullptr && moved != nullptr, "the region serves");
  std::memset(kept, 'k', 100);
  {
    const HeapGateScope scope(HeapRegion::postgres);
    kept = static_cast<char*>(stray_realloc(kept, 50'000));
    expect(kept != nullptr && kept[0] == 'k' && kept[99] == 'k', "kept from call to call");
    expect(moved[0] == 'e' && moved[99] == 'e', "moved from the early region");
    std::free(kept);
    std::free(moved);
  }
  expect(heap_region_report(HeapRegion::postgres).in_use == 0, "all is released");
}

}  // namespace

int main() {
  std::setvbuf(stdout, output_buffer, _IOLBF, sizeof(output_buffer));
  void* early = stray_malloc(100);
  expect(early != nullptr, "before sealing the early region serves");
  early = stray_realloc(early, 5000);
  expect(early != nullptr, "realloc before sealing");
  void* const for_the_server = stray_malloc(100);
  std::memset(for_the_server, 'e', 100);
  static ThreadWorker worker;
  expect(worker.start(worker_stack) == 0, "the worker's thread begins");
  seal_heap(HeapTrapMode::report);
  std::free(early);
  memory_of_the_server_is_kept(for_the_server);
  codec_stays_in_its_region();
  exhaustion_is_a_status();
  jpeg_stays_in_its_region();
  exhaustion_of_jpeg_is_a_status();
  strays_are_caught();
  the_region_is_of_its_thread(worker);
  strict_mode_aborts();
  const HeapRegionReport r = heap_region_report(HeapRegion::early);
  std::printf("    %s: peak %zu of %zu bytes\n", r.name, r.peak, r.bytes);
  return failures == 0 ? 0 : 1;
}
