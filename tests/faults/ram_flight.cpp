#include "tests/faults/ram_flight.hpp"

#include <sys/mman.h>

#include <cstring>
#include <fstream>
#include <new>
#include <sstream>
#include <stdexcept>

#include "fsw/base/crc.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "hal/camera/directory/pgm.hpp"
#include "tests/faults/reveal.hpp"

namespace ilp::faults {
namespace fs = std::filesystem;

ILP_REVEAL(FlightSoftware, components_);

namespace {

constexpr std::size_t region_bytes = std::size_t{32} << 20U;
constexpr int max_starts = 8;

/// Zero at every start of the software, as in a new process.
void* fresh_memory() {
  static void* const place =
      mmap(nullptr, sizeof(FlightSoftware), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (place == MAP_FAILED) throw std::runtime_error("no memory for the flight");
  static_cast<void>(madvise(place, sizeof(FlightSoftware), MADV_DONTNEED));
  return place;
}

}  // namespace

MemoryCamera::MemoryCamera(const fs::path& world) {
  const CameraModel model = tiny_camera(world);
  width_ = model.width;
  height_ = model.height;
  static FrameImage image;
  std::ifstream index(world / "index.txt");
  TimeNs time = 0;
  for (std::string name; index >> time >> name;) {
    if (!read_pgm((world / name).c_str(), image).ok()) throw std::runtime_error("cannot read " + name);
    const auto* pixels = image.view().row(0);
    images_.emplace_back(pixels, pixels + static_cast<std::ptrdiff_t>(width_) * height_);
    times_.push_back(time);
  }
}

Status MemoryCamera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  if (next_ == images_.size()) return {StatusCode::end_of_stream, static_cast<std::int64_t>(next_)};
  if (times_[next_] > now) return StatusCode::not_ready;
  ILP_TRY(image.resize(width_, height_));
  std::memcpy(image.view().row(0), images_[next_].data(), images_[next_].size());
  frame = {};
  frame.time_ns = times_[next_];
  frame.sequence = static_cast<std::int64_t>(++next_);
  return {};
}

Status MemoryLink::begin_file(const char* name) {
  name_ = name;
  open_.clear();
  return {};
}

Status MemoryLink::write(std::span<const std::uint8_t> bytes) {
  open_.insert(open_.end(), bytes.begin(), bytes.end());
  return {};
}

Status MemoryLink::end_file() {
  files[name_] = open_;
  return {};
}

Status MemoryLink::acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) {
  const auto file = files.find(name);
  if (file == files.end()) return StatusCode::not_ready;
  bytes = static_cast<std::uint32_t>(file->second.size());
  crc32 = ilp::crc32(file->second);
  return {};
}

/// Stands in the executive's table for a component, and notes when it is at work.
class RamFlight::Probe final : public Component {
 public:
  Probe(Component& component, std::size_t number, std::size_t& at_work)
      : component_(component), number_(number), at_work_(at_work) {}
  Probe(Probe&& other) noexcept : component_(other.component_), number_(other.number_), at_work_(other.at_work_) {}
  [[nodiscard]] const char* name() const override { return component_.name(); }
  Status restore() override {
    at_work_ = number_;
    const Status status = component_.restore();
    at_work_ = stage_count;
    return status;
  }
  StepResult step() override {
    at_work_ = number_;
    const StepResult result = component_.step();
    at_work_ = stage_count;
    return result;
  }
  [[nodiscard]] LastingMemory lasting() const override { return component_.lasting(); }

 private:
  Component& component_;
  std::size_t number_;
  std::size_t& at_work_;
};

RamFlight::RamFlight(const World& world)
    : region_(region_bytes), ram_(region_), camera_(world.folder), model_(tiny_camera(world.folder)) {
  if (world.packets) ground_ = std::make_unique<PacketGround>(clock_);
  probes_.reserve(stage_count);
}

RamFlight::~RamFlight() = default;

const char* RamFlight::at_work_name() const {
  return at_work_ < stage_count ? schedule[at_work_].name : "executive";
}

bool RamFlight::start() {
  for (failed_starts_ = 0; failed_starts_ < max_starts; ++failed_starts_) {
    mission_ = tiny_mission();
    camera_.rewind();
    // As after the end of a process.
    failing_.rollback();
    software_ = new (fresh_memory()) FlightSoftware({.store = failing_,
                                                     .camera = camera_,
                                                     .link = link_,
                                                     .clock = clock_,
                                                     .nonvolatile_memory = nonvolatile_memory_,
                                                     .packets = ground_ ? &ground_->packets() : nullptr,
                                                     .files = ground_ ? &ground_->files() : nullptr},
                                                    mission_);
    if (!software_->prepare({}).ok()) continue;
    auto& components = software_->*revealed(FlightSoftware_components_{});
    probes_.clear();
    for (std::size_t i = 0; i < stage_count; ++i) {
      probes_.emplace_back(*components[i], i, at_work_);
      components[i] = &probes_.back();
    }
    if (software_->start(model_).ok()) return true;
  }
  return false;
}

void RamFlight::fly_frame() {
  software_->executive().run_minor_frame(next_ns_);
  if (ground_) {
    ground_->listen([this](const std::string& name, const std::vector<std::uint8_t>& file) {
      link_.files[name] = file;
      return true;
    });
  }
  next_ns_ = next_frame_begin(next_ns_, clock_.now());
  clock_.sleep_until(next_ns_);
}

bool RamFlight::fly_until(TimeNs end_ns) {
  int rest = 0;
  while (clock_.now() < end_ns && rest < rest_frames) {
    fly_frame();
    rest = software_->drained() ? rest + 1 : 0;
  }
  return rest == rest_frames;
}

Results RamFlight::results() {
  Results results = results_of(ram_);
  results.files = results_of(link_.files);
  return results;
}

Difference RamFlight::compare_with(const Results& expected, std::set<std::uint16_t>& events) {
  return compare(expected, {}, ram_, link_.files, events);
}

}  // namespace ilp::faults
