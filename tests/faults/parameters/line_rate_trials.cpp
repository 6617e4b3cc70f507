// Telecommands as fast as they are carried out, in some disorder, between replays of what was recorded, forged ones and
// ones of unknown keys, through kills and starts: each is carried out once or, in a kill, not at all.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "fsw/base/rng.hpp"
#include "tests/faults/parameters/kill_at_write.hpp"
#include "tests/faults/parameters/trial_flight.hpp"

namespace ilp::faults {
namespace {

using test::Octets;

constexpr std::uint16_t spi = 7;
constexpr std::uint32_t per_frame = 20;  ///< 200 in a second
constexpr std::uint32_t replays_per_frame = 20, forged_per_frame = 10;
/// Within it sequence numbers may arrive in any order.
constexpr std::uint32_t disorder = 16;
/// A telecommand is answered within as many minor frames. Those of the latest ones before a kill may be lost with it.
constexpr std::int64_t frames_to_answer = 6;
constexpr std::int64_t longest_boot_frames = 900;

/// Lies in shared memory, so that what a process said before it was killed is known.
struct Counts {
  std::int64_t frames, sent, replays, forged, begun, done, starts, kills;
  std::int64_t twice, foreign, refused, most_in_a_frame;
  std::int64_t calendar_s;
};
/// Of one telecommand, how often it was reported so.
struct Reported {
  std::uint8_t begun, done;
};

/// The number of a telecommand is in its source and sequence count, by which reports name it.
Octets telecommand_of(std::uint32_t number) {
  Telecommand telecommand;
  telecommand.primary.apid = 239;
  telecommand.primary.sequence_count = number % sequence_counts;
  telecommand.ack_flags = ack::start | ack::completion;
  telecommand.service = 17;
  telecommand.subtype = 1;
  telecommand.source = static_cast<std::uint16_t>(number / sequence_counts);
  Octets octets(13);
  std::size_t bytes = 0;
  static_cast<void>(encode_telecommand(telecommand, octets, bytes));
  return octets;
}

/// Hears the flight at once: the start of a telecommand is reported before what it changes is committed.
class Radio final : public PacketLink {
 public:
  Radio(test::QueueLink& link, Counts& counts, Reported* reported)
      : link_(link), counts_(counts), reported_(reported) {}
  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override { return link_.receive(buffer, bytes); }
  Status send(std::span<const std::uint8_t> packet) override {
    Telemetry telemetry;
    if (!decode_telemetry(packet, 239, TimeFormat{}, telemetry).ok() || telemetry.service != 1) return {};
    ByteReader in(telemetry.data);
    static_cast<void>(in.u16());
    const std::int64_t number = std::int64_t{telemetry.destination} * sequence_counts + in.u16() % sequence_counts;
    if (number >= counts_.sent) {
      ++counts_.foreign;
      return {};
    }
    const bool begins = telemetry.subtype == verification::start;
    std::uint8_t& times = begins ? reported_[number].begun : reported_[number].done;
    ++(begins ? counts_.begun : counts_.done);
    if (++times > 1) ++counts_.twice;
    return {};
  }

 private:
  test::QueueLink& link_;
  Counts& counts_;
  Reported* reported_;
};

/// One process of the flight.
class Process {
 public:
  Process(test::FlightBoard& board, Counts& counts, const Reported* reported, std::int64_t most)
      : board_(board), counts_(counts), reported_(reported), most_(most) {}

  bool fly(std::int64_t frames, Rng& random) {
    board_.calendar_s = counts_.calendar_s;
    ++counts_.starts;
    if (!board_.start().ok()) return false;
    std::int64_t checked = counts_.sent;
    std::vector<std::int64_t> sent_by;
    for (std::int64_t frame = 0; frame < frames && counts_.sent + per_frame <= most_; ++frame) {
      send(random);
      sent_by.push_back(counts_.sent);
      const std::uint32_t refused = board_.software->router().counts().refused;
      board_.fly(0.1);
      counts_.most_in_a_frame =
          std::max<std::int64_t>(counts_.most_in_a_frame, board_.software->router().counts().refused - refused);
      ++counts_.frames;
      counts_.calendar_s = board_.calendar_now();
      // What was sent so long ago has been carried out.
      if (frame < frames_to_answer) continue;
      const std::int64_t due = sent_by[static_cast<std::size_t>(frame - frames_to_answer)];
      for (; checked < due; ++checked) counts_.refused += reported_[checked].done == 0 ? 1 : 0;
    }
    return true;
  }

 private:
  Octets sealed(std::uint32_t number) { return board_.sealed(telecommand_of(number), number + 1); }
  void send(Rng& random) {
    std::vector<Octets> frame;
    const auto first = static_cast<std::uint32_t>(counts_.sent);
    counts_.sent += per_frame;
    std::vector<std::uint32_t> order(per_frame);
    for (std::uint32_t i = 0; i < per_frame; ++i) order[i] = first + i;
    for (std::uint32_t i = 0; i < per_frame; ++i) {
      const std::uint32_t reach = std::min(disorder, per_frame - i);
      std::swap(order[i], order[i + random.below(reach)]);
    }
    for (const std::uint32_t number : order) frame.push_back(sealed(number));
    for (std::uint32_t i = 0; i < replays_per_frame && first > 0; ++i) {
      // Of this minor frame, behind the telecommand itself; of the latest ones; and of any time.
      const std::uint32_t kind = random.below(3);
      const std::uint32_t number = kind == 0   ? first + random.below(per_frame)
                                   : kind == 1 ? first - 1 - random.below(std::min(first, 100U))
                                               : random.below(first);
      frame.push_back(sealed(number));
      ++counts_.replays;
    }
    for (std::uint32_t i = 0; i < forged_per_frame; ++i) {
      Octets forged = sealed(first + per_frame + random.below(1000));
      forged[random.below(static_cast<std::uint32_t>(forged.size() - 6)) + 6] ^=
          static_cast<std::uint8_t>(1U << random.below(8));
      frame.insert(frame.begin() + random.below(static_cast<std::uint32_t>(frame.size())), forged);
      ++counts_.forged;
    }
    // As datagrams of several packets.
    Octets datagram;
    for (const Octets& packet : frame) {
      datagram.insert(datagram.end(), packet.begin(), packet.end());
      if (random.below(3) != 0) continue;
      board_.send(datagram);
      datagram.clear();
    }
    if (!datagram.empty()) board_.send(datagram);
  }

  test::FlightBoard& board_;
  Counts& counts_;
  const Reported* reported_;
  std::int64_t most_;
};

Fate fly(const CampaignOptions& options, Counts& counts, Reported* reported, std::int64_t most) {
  Rng random(options.seed, 1);
  test::FlightBoard board;
  Radio radio(board.link, counts, reported);
  board.radio = &radio;
  board.key_list = {{spi, Octets(32, 0x42)}};
  board.mission_file.authentication = Authentication::telecommands;
  board.mission_file.link_bytes_per_s = 1e6;
  board.mission_file.trial_s = 60;
  counts.calendar_s = board.calendar_s;
  while (counts.sent + per_frame <= most) {
    const auto frames = 1 + std::int64_t{random.below(longest_boot_frames)};
    // A minor frame of telecommands makes about thirty calls that change a file.
    const bool killed = random.below(4) != 0;
    const std::int64_t kill = killed ? 1 + std::int64_t{random.below(static_cast<std::uint32_t>(30 * frames))} : 0;
    const std::uint64_t seed = random.next();
    const auto boot = [&] {
      Rng own(seed, options.seed);
      Process process(board, counts, reported, most);
      _exit(process.fly(frames, own) ? 0 : 1);
    };
    int status = 0;
    const End end = run_boot(kill, boot, status);
    if (end == End::crashed) return Fate::crash;
    if (end == End::killed) ++counts.kills;
    if (end == End::exited && status != 0) return Fate::no_start;
  }
  const std::int64_t wrong = counts.twice + counts.foreign + counts.refused;
  return wrong == 0 ? Fate::answered : Fate::other_answer;
}

}  // namespace

bool line_rate_trials(const CampaignOptions& options) {
  const std::int64_t most = options.seconds * 10 * per_frame;
  const std::size_t bytes = sizeof(Counts) + static_cast<std::size_t>(most) * sizeof(Reported);
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no shared memory");
  auto* const counts = static_cast<Counts*>(memory);
  auto* const reported = reinterpret_cast<Reported*>(counts + 1);
  const Fate fate = fly(options, *counts, reported, most);
  const auto print = [](const char* what, std::int64_t number) {
    std::printf("| %s | %lld |\n", what, static_cast<long long>(number));
  };
  std::printf("| | %s |\n|---|---|\n", fate_name(fate));
  print("minor frames", counts->frames);
  print("starts", counts->starts);
  print("kills", counts->kills);
  print("telecommands", counts->sent);
  print("replays", counts->replays);
  print("forged", counts->forged);
  print("begun", counts->begun);
  print("completed", counts->done);
  print("not answered before a kill or an end", counts->sent - counts->done);
  print("begun or completed twice", counts->twice);
  print("begun though never sent", counts->foreign);
  print("refused though right", counts->refused);
  print("refused in a minor frame, at most", counts->most_in_a_frame);
  return !breaks_promise(fate);
}

}  // namespace ilp::faults
