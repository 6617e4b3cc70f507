// Who may command: only holders of a key, each packet once, through restarts too.
#include "fsw/packets/authentication.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/commanding/telecommand_guard.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/nonvolatile/ram_nonvolatile.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/support/hex.hpp"
#include "tests/support/loopback_link.hpp"
#include "tests/support/queue_link.hpp"
#include "tests/unit/executive/refusing_store.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

Bytes text_bytes(const std::string& text) {
  return {text.begin(), text.end()};
}

std::string code_of(const Bytes& key, const Bytes& data) {
  const std::span<const std::uint8_t> all(data);
  const std::array<std::span<const std::uint8_t>, 2> parts{all.first(data.size() / 3), all.subspan(data.size() / 3)};
  return to_hex(hmac_sha256(key, parts));
}

TEST(HmacSha256Test, VectorsOfRfc4231) {
  EXPECT_EQ(code_of(Bytes(20, 0x0b), text_bytes("Hi There")),
            "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7");
  EXPECT_EQ(code_of(text_bytes("Jefe"), text_bytes("what do ya want for nothing?")),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
  EXPECT_EQ(code_of(Bytes(20, 0xaa), Bytes(50, 0xdd)),
            "773ea91e36800e46854db8ebd09181a72959098b3ef8c122d9635514ced565fe");
  EXPECT_EQ(code_of(from_hex("0102030405060708090a0b0c0d0e0f10111213141516171819"), Bytes(50, 0xcd)),
            "82558a389a443c0ea4cc819899f2083a85f0faa3e578f8077a2e3ff46729665b");
  EXPECT_EQ(code_of(Bytes(20, 0x0c), text_bytes("Test With Truncation")).substr(0, 32),
            "a3b6167473100ee06e0c796c2955552b");
  EXPECT_EQ(code_of(Bytes(131, 0xaa), text_bytes("Test Using Larger Than Block-Size Key - Hash Key First")),
            "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54");
  EXPECT_EQ(code_of(Bytes(131, 0xaa),
                    text_bytes("This is a test using a larger than block-size key and a larger than block-size data. "
                               "The key needs to be hashed before being used by the HMAC algorithm.")),
            "9b09ffa71b942fcb27635fbcd5b0e944bfdc63644f0713938a7f51535c3a35e2");
}

const Bytes ping = from_hex("18efc00000062f1101000190eb");
const Bytes key = from_hex("000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f");
const Bytes other_key(32, 0x77);
constexpr std::uint16_t spi = 5;

Bytes sealed(std::uint32_t sequence, const Bytes& with = key, std::uint16_t as = spi, const Bytes& packet = ping) {
  Bytes out(packet.size() + security_bytes);
  std::size_t bytes = 0;
  EXPECT_OK(seal(packet, as, sequence, with, out, bytes));
  EXPECT_EQ(bytes, out.size());
  return out;
}

class AuthenticatorTest : public testing::Test {
 protected:
  AuthenticatorTest() { EXPECT_OK(authenticator_.add(spi, key)); }
  Status open(Bytes packet) {
    std::size_t bytes = 0;
    const Status status = authenticator_.open(packet, bytes);
    packet.resize(bytes);
    opened_ = packet;
    return status;
  }
  Authenticator authenticator_;
  Bytes opened_;
};

TEST_F(AuthenticatorTest, TheLayoutIsWhatIsWritten) {
  const Bytes packet = sealed(0x01020304);
  // Python: hmac.new(bytes(range(32)), bytes.fromhex("18efc000001c" "0005" "01020304" "2f1101000190eb"), "sha256")
  EXPECT_EQ(to_hex(packet),
            "18efc000001c"
            "000501020304"
            "2f1101000190eb"
            "421cf486e4039d392b3b9d07cb371213");
}

TEST_F(AuthenticatorTest, WhatWasSealedComesOutAsItWentIn) {
  EXPECT_OK(open(sealed(1)));
  EXPECT_EQ(opened_, ping);
}

TEST_F(AuthenticatorTest, NoBitCanBeChanged) {
  const Bytes good = sealed(1);
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Bytes bad = good;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    EXPECT_FALSE(open(bad).ok()) << "bit " << bit;
    EXPECT_TRUE(opened_.empty());
  }
  EXPECT_OK(open(good));
}

TEST_F(AuthenticatorTest, NoLengthIsTooShortOrTooLong) {
  const Bytes good = sealed(1);
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_FALSE(open(Bytes(good.begin(), good.begin() + long(size))).ok()) << size;
  }
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_STATUS(open(longer), authentication_code);
  EXPECT_STATUS(open(ping), authentication_missing);
}

TEST_F(AuthenticatorTest, KeysBelongToTheirAssociation) {
  EXPECT_STATUS(open(sealed(1, other_key)), authentication_code);
  EXPECT_STATUS(open(sealed(1, key, spi + 1)), authentication_key);
  EXPECT_OK(authenticator_.add(spi + 1, other_key));
  EXPECT_STATUS(open(sealed(1, key, spi + 1)), authentication_code);
  EXPECT_OK(open(sealed(1, other_key, spi + 1)));
  EXPECT_OK(open(sealed(1)));
}

TEST_F(AuthenticatorTest, ASequenceNumberCountsOnce) {
  EXPECT_STATUS(open(sealed(0)), authentication_replay);
  EXPECT_OK(open(sealed(10)));
  EXPECT_STATUS(open(sealed(10)), authentication_replay);
  EXPECT_OK(open(sealed(100)));
  // Packets may overtake each other.
  EXPECT_OK(open(sealed(37)));
  EXPECT_STATUS(open(sealed(37)), authentication_replay);
  EXPECT_STATUS(open(sealed(36)), authentication_replay) << "64 behind the highest";
  EXPECT_OK(open(sealed(99)));
  EXPECT_OK(open(sealed(0xFFFFFFFF)));
  EXPECT_STATUS(open(sealed(100)), authentication_replay);
}

TEST_F(AuthenticatorTest, PacketsThatOvertakeEachOtherByUpTo49AreAllTakenOnce) {
  Rng rng(3);
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t i = 1; i <= 5000; ++i) numbers.push_back(i);
  for (std::size_t block = 0; block < numbers.size(); block += 50) {
    for (std::uint32_t i = 49; i > 0; --i) std::swap(numbers[block + i], numbers[block + rng.below(i + 1)]);
  }
  std::vector<int> taken(5001, 0);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    for (const std::uint32_t n : {numbers[i], numbers[rng.below(static_cast<std::uint32_t>(i) + 1)]}) {
      if (open(sealed(n)).ok()) ++taken[n];
    }
  }
  for (std::uint32_t n = 1; n <= 5000; ++n) EXPECT_EQ(taken[n], 1) << n;
}

TEST_F(AuthenticatorTest, AfterARestartNothingUpToTheMarkIsTaken) {
  EXPECT_OK(open(sealed(50)));
  const SequenceMarks marks = authenticator_.marks();
  Authenticator next;
  EXPECT_OK(next.add(spi, key));
  next.resume(marks);
  authenticator_ = next;
  for (const std::uint32_t n : {1U, 49U, 50U}) EXPECT_STATUS(open(sealed(n)), authentication_replay) << n;
  EXPECT_OK(open(sealed(52)));
  EXPECT_OK(open(sealed(51)));
}

TEST(KeyFileTest, LinesOfIndexAndKey) {
  Authenticator keys;
  const std::string text =
      "# keys of this mission\n\n5 000102030405060708090a0b0c0d0e0f101112131415161718191A1B1C1D1E1F # a\r\n 7\t" +
      std::string(128, 'f');
  EXPECT_OK(keys.add_keys(text));
  EXPECT_EQ(keys.marks().size(), 2U);
  Bytes packet = sealed(1);
  std::size_t bytes = 0;
  EXPECT_OK(keys.open(packet, bytes));
  packet = sealed(1, Bytes(64, 0xFF), 7);
  EXPECT_OK(keys.open(packet, bytes));
}

TEST(KeyFileTest, EverythingElseIsNamedByItsLine) {
  const std::string good(32, '1');
  for (const std::string& line :
       {std::string("5"), std::string("5 "), "0 " + good, "65536 " + good, "5x " + good, "5 " + good + "1",
        "5 " + good + "1g", "5 " + std::string(30, '1'), "5 " + std::string(130, '1'), "-5 " + good,
        "5 " + good + " 11", "6 " + good + "\n6 " + good}) {
    Authenticator keys;
    const std::string text = "# first\n" + line;
    const Status status = keys.add_keys(text);
    EXPECT_STATUS(status, parse_error) << line;
    EXPECT_EQ(status.a, line[0] == '6' && line[1] == ' ' ? 3 : 2) << line;
  }
  Authenticator keys;
  std::string many;
  for (int i = 1; i <= 5; ++i) many += std::to_string(i) + " " + good + "\n";
  EXPECT_STATUS(keys.add_keys(many), capacity_exceeded);
}

/// Fails when a test sets it to.
class BrokenNonvolatile final : public Nonvolatile {
 public:
  Status read(std::span<std::uint8_t> content, std::size_t& bytes) override { return ram_.read(content, bytes); }
  Status write(std::span<const std::uint8_t> content) override {
    return broken ? Status{StatusCode::io_error, 5} : ram_.write(content);
  }
  bool broken = false;

 private:
  RamNonvolatile ram_;
};

/// Router, guard and store as they fly.
class GuardedLinkTest : public testing::Test {
 protected:
  GuardedLinkTest() { start(); }
  void start() {
    keys_ = Authenticator();
    EXPECT_OK(keys_.add(spi, key));
    router_ = std::make_unique<PacketRouter>(&link_->board(), &files_->board(), clock_, mission_);
    router_->authenticate_with(keys_);
    memory_ = std::make_unique<FlightMemory>(medium_);
    static_cast<void>(memory_->load());
    guard_ = std::make_unique<TelecommandGuard>(disk_, *router_, clock_, memory_.get());
    EXPECT_OK(guard_->restore());
  }
  std::size_t received() {
    EXPECT_OK(router_->pump());
    event_ = guard_->step().status;
    std::size_t count = 0, bytes = 0;
    Bytes buffer(1000);
    while (router_->receive(Channel::commands, buffer, bytes).ok()) {
      EXPECT_EQ(Bytes(buffer.begin(), buffer.begin() + long(bytes)), ping);
      ++count;
    }
    return count;
  }
  std::size_t after_sending(const Bytes& packet) {
    EXPECT_OK(link_->ground().send(packet));
    return received();
  }
  std::size_t pdus() {
    std::size_t count = 0, bytes = 0;
    Bytes buffer(1000);
    while (router_->receive(Channel::files, buffer, bytes).ok()) ++count;
    return count;
  }

  VirtualClock clock_;
  MissionParameters mission_;
  Authenticator keys_;
  std::vector<std::byte> region_ = std::vector<std::byte>(1 << 20);
  std::unique_ptr<RamStore> store_ = std::make_unique<RamStore>(region_);
  test::RefusingStore disk_{*store_};
  BrokenNonvolatile medium_;
  std::unique_ptr<FlightMemory> memory_;
  std::unique_ptr<LoopbackLink> link_ = std::make_unique<LoopbackLink>(clock_, LoopbackFaults{});
  std::unique_ptr<LoopbackLink> files_ = std::make_unique<LoopbackLink>(clock_, LoopbackFaults{});
  std::unique_ptr<PacketRouter> router_;
  std::unique_ptr<TelecommandGuard> guard_;
  Status event_;
};

TEST_F(GuardedLinkTest, OffByDefault) {
  EXPECT_EQ(after_sending(ping), 1U);
  EXPECT_OK(event_);
}

TEST_F(GuardedLinkTest, OnlyWhatIsAuthenticGetsThroughAndRefusalsAreToldOnceInAWhile) {
  mission_.authentication = Authentication::telecommands;
  EXPECT_EQ(after_sending(ping), 0U);
  EXPECT_STATUS(event_, telecommands_refused);
  EXPECT_EQ(event_.b, static_cast<std::int64_t>(StatusCode::authentication_missing));
  EXPECT_EQ(after_sending(sealed(1)), 1U);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(after_sending(sealed(1)), 0U);
    EXPECT_OK(event_);
  }
  clock_.sleep_until(10 * ns_per_s);
  EXPECT_EQ(received(), 0U);
  EXPECT_STATUS(event_, telecommands_refused);
  EXPECT_EQ(event_.a, 50);
  EXPECT_EQ(event_.b, static_cast<std::int64_t>(StatusCode::authentication_replay));
}

// 64 datagrams of a minor frame could hold 144 000 packets, each of which costs the check of its code.
TEST_F(GuardedLinkTest, AFloodOfReplaysCostsABoundedNumberOfChecksInAMinorFrame) {
  mission_.authentication = Authentication::telecommands;
  test::QueueLink flooded;
  router_ = std::make_unique<PacketRouter>(&flooded, nullptr, clock_, mission_);
  router_->authenticate_with(keys_);
  guard_ = std::make_unique<TelecommandGuard>(disk_, *router_, clock_);
  ASSERT_OK(guard_->restore());
  const Bytes replay = sealed(100);
  flooded.up.push_back(replay);
  EXPECT_EQ(received(), 1U);
  Bytes datagram;
  while (datagram.size() + replay.size() <= 65'000) datagram.insert(datagram.end(), replay.begin(), replay.end());
  const auto replays = static_cast<std::uint32_t>(64 * (datagram.size() / replay.size()));
  flooded.up.assign(64, datagram);
  std::uint32_t before = 0, most = 0;
  for (int frame = 0; frame < 64 && !flooded.up.empty(); ++frame) {
    EXPECT_EQ(received(), 0U);
    most = std::max(most, router_->counts().refused - before);
    before = router_->counts().refused;
  }
  EXPECT_EQ(before, replays) << "what a minor frame has no time for waits in the link";
  EXPECT_LE(most, 4200U);
  EXPECT_GE(most, 1000U);
  flooded.up.push_back(sealed(101));
  EXPECT_EQ(received(), 1U);
}

TEST_F(GuardedLinkTest, NothingIsReleasedBeforeItsNumberIsOnDisk) {
  mission_.authentication = Authentication::telecommands;
  EXPECT_OK(link_->ground().send(sealed(1)));
  EXPECT_OK(router_->pump());
  Bytes buffer(1000);
  std::size_t bytes = 0;
  EXPECT_STATUS(router_->receive(Channel::commands, buffer, bytes), not_ready);
  EXPECT_EQ(received(), 1U);
}

TEST_F(GuardedLinkTest, AReplayAfterARestartIsRefused) {
  mission_.authentication = Authentication::telecommands;
  EXPECT_EQ(after_sending(sealed(7)), 1U);
  start();
  EXPECT_EQ(after_sending(sealed(7)), 0U);
  EXPECT_EQ(after_sending(sealed(6)), 0U);
  EXPECT_EQ(after_sending(sealed(8)), 1U);
}

TEST_F(GuardedLinkTest, AReplayIsRefusedAfterTheDatabaseWasSetAside) {
  mission_.authentication = Authentication::telecommands;
  EXPECT_EQ(after_sending(sealed(7)), 1U);
  store_->number_from(0, 0);
  Transaction transaction(*store_);
  EXPECT_OK(transaction.begin());
  EXPECT_OK(store_->erase(record_info<CheckpointRecord>(), static_cast<std::int64_t>(ComponentId::telecommand_guard)));
  EXPECT_OK(transaction.commit());
  start();
  EXPECT_EQ(after_sending(sealed(7)), 0U) << "recorded, and sent again";
  EXPECT_EQ(after_sending(sealed(8)), 1U);
}

TEST_F(GuardedLinkTest, OneOfTheTwoPlacesIsEnoughForAMark) {
  mission_.authentication = Authentication::telecommands;
  disk_.full = true;
  EXPECT_EQ(after_sending(sealed(1)), 1U) << "a full disk locks nobody out";
  start();
  EXPECT_EQ(after_sending(sealed(1)), 0U);
  disk_.full = false;
  medium_.broken = true;
  EXPECT_EQ(after_sending(sealed(2)), 1U);
  start();
  EXPECT_EQ(after_sending(sealed(2)), 0U);
}

TEST_F(GuardedLinkTest, WhereMarksCannotBeKeptTelecommandsWaitAndThenGoBefore) {
  mission_.authentication = Authentication::telecommands;
  disk_.full = medium_.broken = true;
  EXPECT_EQ(after_sending(sealed(1)), 0U);
  EXPECT_STATUS(event_, store_full);
  clock_.sleep_until(9 * ns_per_s);
  EXPECT_EQ(after_sending(sealed(2)), 0U) << "nothing is released whose mark is not kept";
  clock_.sleep_until(10 * ns_per_s);
  EXPECT_EQ(received(), 2U) << "the ground is not locked out";
  EXPECT_STATUS(event_, marks_not_kept);
  EXPECT_EQ(event_.a, 2);
  EXPECT_EQ(event_.b, 10);
  clock_.sleep_until(11 * ns_per_s);
  EXPECT_EQ(after_sending(sealed(3)), 1U) << "it has waited once";
  EXPECT_OK(event_);
  clock_.sleep_until(20 * ns_per_s);
  EXPECT_EQ(received(), 0U);
  EXPECT_STATUS(event_, marks_not_kept);
  EXPECT_EQ(event_.a, 1);
  // With room again everything is as before, also for what had gone before.
  disk_.full = medium_.broken = false;
  EXPECT_EQ(received(), 0U);
  EXPECT_OK(event_);
  start();
  EXPECT_EQ(after_sending(sealed(3)), 0U);
  disk_.full = medium_.broken = true;
  EXPECT_EQ(after_sending(sealed(4)), 0U) << "and the next trouble waits again";
}

TEST_F(GuardedLinkTest, MarksOfKeysThatAreNotInUseStay) {
  FlightMemoryContent content;
  content.marks[0] = {900, 77, 0};
  ASSERT_TRUE(memory_->keep(content).ok());
  mission_.authentication = Authentication::telecommands;
  EXPECT_EQ(after_sending(sealed(5)), 1U);
  EXPECT_EQ(memory_->content().marks[0], (SequenceMark{900, 77, 0}));
  EXPECT_EQ(memory_->content().marks[1], (SequenceMark{5, spi, 0}));
}

TEST_F(GuardedLinkTest, PdusAreProtectedWhenAskedFor) {
  const Bytes wrapped = from_hex("07fdc000001b300012110001000500020000000048656c6c6f2c2067726f756e642e");
  const Bytes bare(wrapped.begin() + 6, wrapped.end());
  mission_.authentication = Authentication::telecommands;
  EXPECT_EQ(after_sending(wrapped), 0U);
  EXPECT_OK(files_->ground().send(bare));
  EXPECT_EQ(received(), 0U);
  EXPECT_EQ(pdus(), 2U);
  mission_.authentication = Authentication::telecommands_and_files;
  EXPECT_EQ(after_sending(wrapped), 0U);
  EXPECT_OK(files_->ground().send(bare));
  EXPECT_EQ(received(), 0U);
  EXPECT_EQ(pdus(), 0U);
  EXPECT_EQ(after_sending(sealed(1, key, spi, wrapped)), 0U);
  EXPECT_EQ(pdus(), 1U);
}

TEST_F(GuardedLinkTest, WithoutKeysItIsOffAndThatIsTold) {
  keys_ = Authenticator();
  mission_.authentication = Authentication::telecommands;
  EXPECT_EQ(after_sending(ping), 1U);
  EXPECT_STATUS(event_, authentication_off);
  EXPECT_EQ(after_sending(ping), 1U);
  EXPECT_OK(event_);
}

}  // namespace
}  // namespace ilp
