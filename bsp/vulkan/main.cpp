// ilp-compute-vulkan: computes jobs of a flight on a Vulkan device (docs/compute.md). It is a program of its own,
// because drivers allocate memory and the flight does not.

#include <cstdio>
#include <cstring>

#include "bsp/vulkan/measure.hpp"
#include "bsp/vulkan/vulkan_device.hpp"
#include "bsp/vulkan/wide_search_job.hpp"
#include "fsw/imaging/wide_overlap.hpp"
#include "hal/compute/shared/compute_server.hpp"

namespace {

using namespace ilp;

const char* const usage =
    "Searches overlaps of large rotations for a flight on a Vulkan device\n"
    "usage: ilp-compute-vulkan --socket PATH [--device NAME]\n"
    "       ilp-compute-vulkan --measure [--device NAME]\n"
    "       ilp-compute-vulkan --list\n"
    "  --socket   the Unix socket at which a flight finds this program: ilp-onboard --compute PATH\n"
    "  --device   a part of the device's name; without it the first one that can do the work\n"
    "  --measure  does a search on the device and on the processor, and prints both times\n"
    "  --list     prints the devices\n"
    "Example: ilp-compute-vulkan --socket /run/ilp/compute\n"
    "Exit status: 0 done, 1 the device cannot be used or has failed, 2 wrong call\n";

struct Options {
  const char* socket = nullptr;
  const char* device = nullptr;
  bool list = false;
  bool measure = false;
};

bool parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const char* const value = i + 1 < argc ? argv[i + 1] : nullptr;
    if (std::strcmp(argv[i], "--list") == 0) {
      options.list = true;
    } else if (std::strcmp(argv[i], "--measure") == 0) {
      options.measure = true;
    } else if (std::strcmp(argv[i], "--socket") == 0 && value != nullptr) {
      options.socket = argv[++i];
    } else if (std::strcmp(argv[i], "--device") == 0 && value != nullptr) {
      options.device = argv[++i];
    } else {
      return false;
    }
  }
  return options.list + options.measure + (options.socket != nullptr) == 1;
}

int fail(const char* what, const Status& status) {
  std::fprintf(stderr, "ilp-compute-vulkan: %s: %s (%lld)\n", what, status_name(status.code),
               static_cast<long long>(status.a));
  return 1;
}

/// Serves one flight until it ends. Returns false when the device fails: the flight then goes on without it.
bool serve(ComputeServer& server, WideSearchJob& search) {
  ComputeJob job;
  while (server.next(job).ok()) {
    if (!search.run(job.input, job.output)) return false;
    if (!server.answer(job).ok()) return true;
  }
  return true;
}

WideWorkspace workspace;
VulkanDevice device;
WideSearchJob search;

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--help") == 0) {
    std::fputs(usage, stdout);
    return 0;
  }
  Options options;
  if (!parse(argc, argv, options)) {
    std::fputs(usage, stderr);
    return 2;
  }
  if (options.list) return VulkanDevice::list() ? 0 : 1;
  if (!device.open(options.device) || !search.prepare(device)) return 1;
  if (options.measure) {
    std::printf("%s\n", device.name());
    return measure_wide_search(search) ? 0 : 1;
  }
  const ComputeForms forms{wide_search_form(workspace)};
  static ComputeServer server(forms);
  const Status listening = server.listen(options.socket);
  if (!listening.ok()) return fail(options.socket, listening);
  std::fprintf(stderr, "ilp-compute-vulkan: %s at %s\n", device.name(), options.socket);
  for (;;) {
    const Status accepted = server.accept();
    if (accepted.is(StatusCode::io_error)) return fail(options.socket, accepted);
    if (!accepted.ok()) {
      static_cast<void>(fail("no flight, or one of another build", accepted));
    } else if (!serve(server, search)) {
      return 1;
    }
  }
}
