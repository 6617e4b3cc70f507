// A compute device that is right, late, gone, damaged or wrong: the bytes are those of the processor, and an event
// tells.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "fsw/base/rng.hpp"
#include "hal/compute/guarded_compute.hpp"
#include "hal/compute/shared/compute_server.hpp"
#include "hal/compute/shared/compute_socket.hpp"
#include "hal/compute/shared/shared_compute.hpp"

namespace ilp {
/// The compiler looks at the fields of structs with linkage only.
struct SizeOfJob {
  std::int32_t width, rows;
};
struct SwappedSize {
  std::int32_t rows, width;
};

namespace {

constexpr std::size_t input_bytes = 1024, units = 8, unit_bytes = 64;
using Input = std::array<std::byte, input_bytes>;
using Output = std::array<std::byte, units * unit_bytes>;

void compute_unit(void*, std::span<const std::byte> input, std::size_t unit, std::span<std::byte> output) {
  std::uint64_t sum = unit;
  for (const std::byte byte : input) sum = mix64(sum + static_cast<std::uint64_t>(byte));
  for (std::byte& byte : output) byte = static_cast<std::byte>(sum = mix64(sum));
}
void example(void*, std::uint32_t number, std::span<std::byte> input) {
  for (std::size_t i = 0; i < input.size(); ++i) input[i] = static_cast<std::byte>(mix64(number * 7919 + i));
}
ComputeForms test_forms() {
  ComputeForms forms;
  forms.fill({input_bytes, units, unit_bytes, 3, compute_unit, example, nullptr, 1});
  return forms;
}

Input input_of(std::uint32_t number) {
  Input input;
  example(nullptr, 1000 + number, input);
  return input;
}
Output answer_of(const Input& input) {
  Output output;
  for (std::size_t unit = 0; unit < units; ++unit) {
    compute_unit(nullptr, input, unit, std::span(output).subspan(unit * unit_bytes, unit_bytes));
  }
  return output;
}

/// The program of a device, in a thread: does the jobs of one flight, and treats job number `turn` in its own way.
class Program {
 public:
  using Turn = std::function<bool(ComputeServer&, const ComputeJob&)>;  ///< false ends the program

  Program(int turn, Turn act) : path_("/tmp/ilp-compute-test-" + std::to_string(getpid())), server_(forms_) {
    EXPECT_TRUE(server_.listen(path_.c_str()).ok());
    thread_ = std::thread([this, turn, act] { work(turn, act); });
  }
  ~Program() {
    thread_.join();
    std::filesystem::remove(path_);
  }
  [[nodiscard]] const char* path() const { return path_.c_str(); }

  static void do_job(const ComputeJob& job) {
    for (std::size_t unit = 0; unit < units; ++unit) {
      compute_unit(nullptr, job.input, unit, job.output.subspan(unit * unit_bytes, unit_bytes));
    }
  }

 private:
  void work(int turn, const Turn& act) {
    {
      ComputeJob job;
      if (!server_.accept().ok()) return;
      for (int number = 0; server_.next(job).ok(); ++number) {
        if (number == turn) {
          if (!act(server_, job)) break;
          continue;
        }
        do_job(job);
        if (!server_.answer(job).ok()) break;
      }
    }
    server_.leave();
  }

  std::string path_;
  const ComputeForms forms_ = test_forms();
  ComputeServer server_;
  std::thread thread_;
};

/// A flight with a device; the job limit is short, so that a late one does not hold up the test.
struct Flight {
  ComputeForms forms = test_forms();
  SharedCompute device{forms};
  GuardedCompute compute{forms};
  Input scratch_in{};
  Output scratch_out{};

  Status begin(const char* path, TimeNs limit_ns) {
    static_cast<void>(device.open({path, limit_ns}));
    return compute.accept(device, scratch_in, scratch_out);
  }
  /// Does a job as a component does: submits it, and asks until it is done.
  Output does(const Input& input) {
    Output output{};
    EXPECT_TRUE(compute.submit({ComputeKind::wide_search, input, output}).ok());
    ComputeProgress progress = ComputeProgress::working;
    while (progress != ComputeProgress::done) {
      progress = compute.ask(ComputeKind::wide_search);
      EXPECT_NE(progress, ComputeProgress::none);
      if (progress == ComputeProgress::waiting) device.pause();
    }
    EXPECT_EQ(compute.ask(ComputeKind::wide_search), ComputeProgress::none);
    return output;
  }
};

constexpr TimeNs no_limit = 100 * ns_per_s;
constexpr int compared = 2 * static_cast<int>(compute_kinds);  // jobs at the start

/// Ten jobs with a program that treats the third one after the start in its own way.
void expect_lost(ComputeFault fault, TimeNs limit_ns, const Program::Turn& act) {
  Program program(compared + 2, act);
  Flight flight;
  ASSERT_TRUE(flight.begin(program.path(), no_limit).ok());
  EXPECT_TRUE(flight.compute.take_updates().is(StatusCode::compute_ready));
  flight.device.limit(limit_ns);
  for (std::uint32_t number = 0; number < 10; ++number) {
    const Input input = input_of(number);
    EXPECT_EQ(flight.does(input), answer_of(input)) << number;
    const Status updates = flight.compute.take_updates();
    EXPECT_EQ(updates.is(StatusCode::compute_lost), number == 2) << number;
    if (number == 2) {
      EXPECT_EQ(updates.a, static_cast<std::int64_t>(fault));
    }
    EXPECT_EQ(flight.compute.on_device(), number < 2);
  }
}

TEST(Compute, TheProcessorDoesAFewUnitsEachTimeItIsAsked) {
  const ComputeForms forms = test_forms();
  CpuCompute cpu(forms);
  const Input input = input_of(1);
  Output output{};
  ASSERT_TRUE(cpu.submit({ComputeKind::wide_search, input, output}).ok());
  EXPECT_EQ(cpu.ask(ComputeKind::wide_search), ComputeProgress::working);
  EXPECT_EQ(cpu.ask(ComputeKind::wide_search), ComputeProgress::working);
  EXPECT_EQ(cpu.ask(ComputeKind::wide_search), ComputeProgress::done);
  EXPECT_EQ(output, answer_of(input));
  EXPECT_TRUE(
      cpu.submit({ComputeKind::wide_search, std::span(input).first(5), output}).is(StatusCode::invalid_argument));
  EXPECT_TRUE(cpu.submit({ComputeKind::count, input, output}).is(StatusCode::invalid_argument));
}

TEST(Compute, ADeviceThatIsRightDoesAllJobs) {
  std::atomic<int> done = 0;
  {
    Program program(compared + 7, [&](ComputeServer& server, const ComputeJob& job) {
      ++done;
      Program::do_job(job);
      return server.answer(job).ok();
    });
    Flight flight;
    ASSERT_TRUE(flight.begin(program.path(), no_limit).ok());
    for (std::uint32_t number = 0; number < 10; ++number) {
      const Input input = input_of(number);
      EXPECT_EQ(flight.does(input), answer_of(input));
    }
    EXPECT_TRUE(flight.compute.on_device());
  }
  EXPECT_EQ(done, 1);
}

TEST(Compute, AProgramThatEndsInAJobIsGone) {
  expect_lost(ComputeFault::gone, no_limit, [](ComputeServer&, const ComputeJob&) { return false; });
}

TEST(Compute, ADeviceThatGivesNoAnswerIsLate) {
  expect_lost(ComputeFault::late, 50 * ns_per_ms, [](ComputeServer&, const ComputeJob&) { return true; });
}

TEST(Compute, AWrongByteInEveryUnitIsSeenWhateverItsChecksum) {
  expect_lost(ComputeFault::wrong, no_limit, [](ComputeServer& server, const ComputeJob& job) {
    Program::do_job(job);
    for (std::size_t unit = 0; unit < units; ++unit) job.output[unit * unit_bytes + unit] ^= std::byte{1};
    return server.answer(job).ok();
  });
}

ComputeMailbox& box_of(ComputeServer& server) {
  return reinterpret_cast<ComputeHeader*>(server.memory().data())->boxes[0];
}

TEST(Compute, AResultWithoutItsChecksumIsDamaged) {
  expect_lost(ComputeFault::damaged, no_limit, [](ComputeServer& server, const ComputeJob& job) {
    Program::do_job(job);
    ComputeMailbox& box = box_of(server);
    box.output_sum = compute_sum(job.output, job.kind, box.asked + 1);
    std::atomic_ref(box.answered).store(box.asked);
    return true;
  });
}

TEST(Compute, AnAnswerToAJobThatNobodyHasAskedForIsDamaged) {
  expect_lost(ComputeFault::damaged, no_limit, [](ComputeServer& server, const ComputeJob&) {
    ComputeMailbox& box = box_of(server);
    std::atomic_ref(box.answered).store(box.asked + 1);
    return true;
  });
}

TEST(Compute, GarbageAllOverTheMemoryIsDamaged) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    expect_lost(ComputeFault::damaged, no_limit, [seed](ComputeServer& server, const ComputeJob&) {
      const std::span<std::byte> memory = server.memory();
      for (std::size_t i = 0; i < memory.size(); ++i) {
        memory[i] = static_cast<std::byte>(mix64(seed * 1000003 + i) | 0x80U);
      }
      return true;
    });
  }
}

TEST(Compute, AWrongResultAtTheStartRefusesTheDevice) {
  Program program(1, [](ComputeServer& server, const ComputeJob& job) {
    Program::do_job(job);
    job.output.back() ^= std::byte{1};
    return server.answer(job).ok();
  });
  Flight flight;
  const Status refused = flight.begin(program.path(), no_limit);
  EXPECT_TRUE(refused.is(StatusCode::compute_refused));
  EXPECT_EQ(refused.a, static_cast<std::int64_t>(ComputeFault::wrong));
  EXPECT_FALSE(flight.compute.on_device());
  const Input input = input_of(4);
  EXPECT_EQ(flight.does(input), answer_of(input));
}

TEST(Compute, WithoutAProgramTheFlightGoesOn) {
  Flight flight;
  const Status refused = flight.begin("/tmp/ilp-compute-nobody", no_limit);
  EXPECT_TRUE(refused.is(StatusCode::compute_refused));
  EXPECT_EQ(refused.a, static_cast<std::int64_t>(ComputeFault::unreachable));
  const Input input = input_of(4);
  EXPECT_EQ(flight.does(input), answer_of(input));
}

TEST(Compute, ADroppedJobLeavesNoTrace) {
  Program program(-1, {});
  Flight flight;
  ASSERT_TRUE(flight.begin(program.path(), no_limit).ok());
  for (std::uint32_t number = 0; number < 20; ++number) {
    const Input dropped = input_of(100 + number), input = input_of(number);
    Output untouched{};
    ASSERT_TRUE(flight.compute.submit({ComputeKind::wide_search, dropped, untouched}).ok());
    flight.compute.drop(ComputeKind::wide_search);
    EXPECT_EQ(flight.compute.ask(ComputeKind::wide_search), ComputeProgress::none);
    EXPECT_EQ(flight.does(input), answer_of(input));
    EXPECT_EQ(untouched, Output{});
  }
  EXPECT_TRUE(flight.compute.on_device());
}

// The flight makes the memory and seals its size: a program that shrinks it would kill the flight otherwise.
TEST(Compute, NobodyCanShrinkTheSharedMemory) {
  const std::string path = "/tmp/ilp-compute-seal-" + std::to_string(getpid());
  int listener = -1, socket = -1, memory = -1;
  ASSERT_TRUE(listen_compute(path.c_str(), listener).ok());
  Flight flight;
  ASSERT_EQ(flight.device.open({path.c_str(), no_limit}), ComputeFault::none);
  ASSERT_TRUE(accept_compute(listener, socket, memory).ok());
  EXPECT_NE(::ftruncate(memory, 0), 0);
  EXPECT_NE(::ftruncate(memory, 1 << 24), 0);
  for (const int file : {listener, socket, memory}) ::close(file);
  std::filesystem::remove(path);
}

TEST(SharedCompute, AMemoryWithOtherFieldsOfEqualSizeIsRefused) {
  ComputeForms forms = test_forms();
  forms[0].layout = job_layout<SizeOfJob, SizeOfJob>();
  ComputeMemory made, mapped;
  ASSERT_TRUE(made.make(compute_header(forms)).ok());
  EXPECT_TRUE(mapped.map(made.file(), compute_header(forms)).ok());
  forms[0].layout = job_layout<SwappedSize, SizeOfJob>();
  EXPECT_TRUE(mapped.map(made.file(), compute_header(forms)).is(StatusCode::parse_error));
}

/// A program that goes on after each client that is no flight.
class PatientProgram {
 public:
  PatientProgram() : path_("/tmp/ilp-compute-patient-" + std::to_string(getpid())), server_(forms_) {
    EXPECT_TRUE(server_.listen(path_.c_str()).ok());
    thread_ = std::thread([this] {
      Status accepted;
      while ((accepted = server_.accept()).is(StatusCode::parse_error)) ++refused_;
      EXPECT_TRUE(accepted.ok());
      for (ComputeJob job; server_.next(job).ok();) {
        Program::do_job(job);
        EXPECT_TRUE(server_.answer(job).ok());
      }
      server_.leave();
    });
  }
  ~PatientProgram() {
    thread_.join();
    std::filesystem::remove(path_);
  }
  [[nodiscard]] const char* path() const { return path_.c_str(); }
  [[nodiscard]] int refused() const { return refused_; }
  [[nodiscard]] int connect() const {
    const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof(address.sun_path) - 1);
    EXPECT_EQ(::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    return socket;
  }

 private:
  std::string path_;
  const ComputeForms forms_ = test_forms();
  ComputeServer server_;
  std::atomic<int> refused_ = 0;
  std::thread thread_;
};

TEST(ComputeSocket, WhoSaysNothingKeepsNoFlightAway) {
  PatientProgram program;
  const int gone = program.connect();
  ::close(gone);
  const int without_file = program.connect();
  EXPECT_EQ(::send(without_file, "x", 1, 0), 1);
  while (program.refused() < 2) std::this_thread::yield();
  const int silent = program.connect();
  {
    Flight flight;
    ASSERT_TRUE(flight.begin(program.path(), no_limit).ok());
    EXPECT_EQ(flight.does(input_of(1)), answer_of(input_of(1)));
    EXPECT_TRUE(flight.compute.take_updates().is(StatusCode::compute_ready));
  }
  EXPECT_EQ(program.refused(), 3);
  ::close(silent);
  ::close(without_file);
}

TEST(ComputeSocket, IsForItsOwnerAlone) {
  const std::string path = "/tmp/ilp-compute-owner-" + std::to_string(getpid());
  int listener = -1;
  ASSERT_TRUE(listen_compute(path.c_str(), listener).ok());
  EXPECT_EQ(std::filesystem::status(path).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  ::close(listener);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace ilp
