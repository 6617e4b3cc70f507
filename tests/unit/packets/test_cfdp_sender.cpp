#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "fsw/packets/cfdp_gaps.hpp"
#include "fsw/packets/cfdp_sender.hpp"

namespace ilp::cfdp {
namespace {

/// Pieces as a NAK names them, one after the other.
MergeCounts add(SegmentList& list, std::vector<Segment> segments) {
  return merge_missing(list, segments);
}

TEST(CfdpGaps, HoldWhatIsAskedForOnceAndKeepBorders) {
  SegmentList list;
  for (const Segment& segment : {Segment{10, 20}, {20, 30}, {5, 35}, {12, 25}, {7, 7}, {9, 3}}) {
    EXPECT_EQ(add(list, {segment}).dropped, 0U);
  }
  ASSERT_EQ(list.size(), 4U);
  const std::uint32_t borders[] = {5, 10, 20, 30, 35};
  for (std::size_t i = 0; i < list.size(); ++i) {
    EXPECT_EQ(list[i].begin, borders[i]);
    EXPECT_EQ(list[i].end, borders[i + 1]);
  }
}

TEST(CfdpGaps, AnyRequestsGiveTheirUnionAscendingWithoutOverlap) {
  std::uint32_t random = 1;
  const auto next_random = [&](std::uint32_t below) {
    return (random = random * 1664525U + 1013904223U) / 65536U % below;
  };
  for (int trial = 0; trial < 1000; ++trial) {
    SegmentList list;
    std::set<std::uint32_t> asked, borders;
    for (int nak = 0; nak < 4; ++nak) {
      std::vector<Segment> segments;
      for (int i = 0; i < 8; ++i) {
        const std::uint32_t begin = next_random(100);
        segments.push_back({begin, begin + next_random(20)});
        for (std::uint32_t at = begin; at < segments.back().end; ++at) asked.insert(at);
      }
      // What was held keeps its borders.
      const SegmentList before = list;
      EXPECT_EQ(add(list, segments).dropped, 0U);
      for (const Segment& held : before) {
        EXPECT_TRUE(std::any_of(list.begin(), list.end(), [&](const Segment& segment) {
          return segment.begin == held.begin && segment.end == held.end;
        }));
      }
    }
    std::vector<std::uint32_t> held;
    for (const Segment& segment : list) {
      for (std::uint32_t at = segment.begin; at < segment.end; ++at) held.push_back(at);
    }
    EXPECT_EQ(held, std::vector<std::uint32_t>(asked.begin(), asked.end()));
  }
}

TEST(CfdpGaps, AFullListKeepsWhatItHolds) {
  SegmentList list;
  std::vector<Segment> even, all;
  for (std::uint32_t i = 0; i < limits::max_file_gaps; ++i) even.push_back({100 + 20 * i, 110 + 20 * i});
  EXPECT_EQ(add(list, even).dropped, 0U);
  EXPECT_EQ(add(list, {{0, 100 + 20 * limits::max_file_gaps}}).dropped, limits::max_file_gaps + 1);
  ASSERT_EQ(list.size(), limits::max_file_gaps);
  for (std::size_t i = 0; i < list.size(); ++i) EXPECT_EQ(list[i].begin, even[i].begin);
}

TEST(CfdpGaps, AMergeTakesStepsInProportionToWhatItMerges) {
  // 250 gaps that all overlap the 256 that are held, ascending and in the worst order.
  for (const bool ascending : {true, false}) {
    SegmentList list;
    std::vector<Segment> held, asked;
    for (std::uint32_t i = 0; i < limits::max_file_gaps; ++i) held.push_back({10 * i, 10 * i + 5});
    add(list, held);
    for (std::uint32_t i = 0; i < 250; ++i) asked.push_back({10 * i + 2, 10 * i + 9});
    if (!ascending) std::reverse(asked.begin(), asked.end());
    const MergeCounts counts = add(list, asked);
    const auto segments = static_cast<std::uint32_t>(held.size() + asked.size());
    // n log2 n of heapsort, twice, where they have to be put in order.
    EXPECT_LE(counts.steps, ascending ? 4 * segments : 4 * segments + 2 * 250 * 8);
  }
}

TEST(CfdpGaps, CuttingOutLeavesTheRestOrNothingChanged) {
  SegmentList list;
  ASSERT_TRUE(list.push_back({0, 100}));
  ASSERT_TRUE(cut_out(list, {40, 60}));
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].end, 40U);
  EXPECT_EQ(list[1].begin, 60U);
  ASSERT_TRUE(cut_out(list, {30, 70}));
  EXPECT_EQ(octets_in(list), 60U);
  list.clear();
  for (std::uint32_t i = 0; i < limits::max_file_gaps; ++i) ASSERT_TRUE(list.push_back({10 * i, 10 * i + 8}));
  EXPECT_FALSE(cut_out(list, {2, 4}));
  EXPECT_EQ(octets_in(list), 8 * limits::max_file_gaps);
  EXPECT_EQ(add(list, {{8, 10}}).dropped, 1U);
  EXPECT_TRUE(cut_out(list, {0, 8}));
}

class CfdpSenderTest : public testing::Test {
 protected:
  CfdpSenderTest() {
    order.file_bytes = 250;
    order.header.source = 1;
    order.header.destination = 2;
    order.header.sequence = 5;
    order.checksum = 0x01020304;
    order.name[0] = 'a';
    settings.segment_bytes = 100;
    sender.begin(order, settings);
  }

  /// What goes now, at most `most` of it.
  std::vector<SendItem> go(std::size_t most = 1000) {
    std::vector<SendItem> items;
    SendItem item;
    while (items.size() < most && sender.next(item)) {
      sender.sent(item, now);
      items.push_back(item);
    }
    return items;
  }
  void receive_nak(std::vector<Gap> gaps) {
    octets.assign(gaps.size() * 16, 0);
    std::size_t size = 0;
    for (const Gap& gap : gaps) size += write_gap(order.header, gap, octets.data() + size);
    Pdu pdu{.header = order.header, .kind = PduKind::nak};
    pdu.nak.gaps = std::span<const std::uint8_t>(octets).first(size);
    sender.receive(pdu, now);
  }
  void receive_ack(TransactionStatus status = TransactionStatus::active) {
    Pdu pdu{.kind = PduKind::ack};
    pdu.ack.status = status;
    sender.receive(pdu, now);
  }
  void receive_finished(Condition condition = Condition::no_error, bool incomplete = false,
                        FileStatus status = FileStatus::retained) {
    Pdu pdu{.kind = PduKind::finished, .finished = {condition, incomplete, status, {}}};
    sender.receive(pdu, now);
  }
  /// Time passes second by second; the EOFs, metadata and prompts that go.
  std::vector<PduKind> wait(int seconds) {
    std::vector<PduKind> kinds;
    for (int i = 0; i < seconds; ++i) {
      now += ns_per_s;
      sender.tick(now);
      for (const SendItem& item : go()) kinds.push_back(item.kind);
    }
    return kinds;
  }
  static std::size_t number(const std::vector<PduKind>& kinds, PduKind kind) {
    return static_cast<std::size_t>(std::count(kinds.begin(), kinds.end(), kind));
  }

  SendOrder order;
  SenderSettings settings;
  Sender sender;
  TimeNs now = 0;
  std::vector<std::uint8_t> octets;
};

TEST_F(CfdpSenderTest, SendsMetadataTwiceThenTheFileThenTheEof) {
  const auto items = go();
  ASSERT_EQ(items.size(), 6U);
  EXPECT_EQ(items[0].kind, PduKind::metadata);
  EXPECT_EQ(items[1].kind, PduKind::metadata);
  const std::uint32_t borders[] = {0, 100, 200, 250};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(items[2 + i].kind, PduKind::file_data);
    EXPECT_EQ(items[2 + i].segment.begin, borders[i]);
    EXPECT_EQ(items[2 + i].segment.end, borders[i + 1]);
  }
  EXPECT_EQ(items[5].kind, PduKind::eof);
  Pdu pdu;
  sender.build(items[5], pdu);
  EXPECT_EQ(pdu.eof.checksum, 0x01020304U);
  EXPECT_EQ(pdu.eof.file_bytes, 250U);
  EXPECT_EQ(sender.phase(), SendPhase::answer);
}

TEST_F(CfdpSenderTest, CutsRetransmissionsExactlyToTheGaps) {
  go();
  receive_nak({{30, 40}, {0, 0}, {50, 205}});
  const auto items = go();
  ASSERT_EQ(items.size(), 4U);
  EXPECT_EQ(items[0].kind, PduKind::metadata);
  EXPECT_EQ(items[1].segment.begin, 30U);
  EXPECT_EQ(items[1].segment.end, 40U);
  EXPECT_EQ(items[2].segment.begin, 50U);
  EXPECT_EQ(items[2].segment.end, 150U);
  EXPECT_EQ(items[3].segment.begin, 150U);
  EXPECT_EQ(items[3].segment.end, 205U);
  EXPECT_EQ(sender.counts().resent_bytes, 165U);
}

TEST_F(CfdpSenderTest, HostileGapsAreClippedAndCounted) {
  go();
  receive_nak({{240, 0xFFFFFFFF}, {60, 50}, {300, 400}, {70, 70}, {0, 250}, {10, 20}});
  EXPECT_EQ(sender.counts().bad_gaps, 4U);
  EXPECT_EQ(octets_in(sender.gaps()), 250U);
  for (const SendItem& item : go()) EXPECT_LE(item.segment.end, 250U);
  // More gaps than the list holds: dropped, counted, never beyond the list.
  Sender large;
  order.file_bytes = 100000;
  large.resume(order, settings, 100000, true, {});
  sender = large;
  for (int part = 0; part < 4; ++part) {
    std::vector<Gap> many;
    for (std::uint64_t i = 0; i < 120; ++i)
      many.push_back({(120 * static_cast<unsigned>(part) + i) * 10, (120 * static_cast<unsigned>(part) + i) * 10 + 1});
    receive_nak(many);
  }
  EXPECT_EQ(sender.gaps().size(), limits::max_file_gaps);
  EXPECT_EQ(sender.counts().dropped_gaps, 480 - limits::max_file_gaps);
}

TEST_F(CfdpSenderTest, WhatHasNotGoneYetIsNotRepeated) {
  go(3);  // metadata twice, the first 100 bytes
  receive_nak({{50, 250}});
  const auto items = go();
  ASSERT_EQ(items.size(), 4U);
  EXPECT_EQ(items[0].segment.begin, 50U);
  EXPECT_EQ(items[0].segment.end, 100U);
  EXPECT_EQ(items[1].segment.begin, 100U);
  EXPECT_EQ(items[3].kind, PduKind::eof);
}

TEST_F(CfdpSenderTest, RepeatsTheEofRestsAndGoesOnWithMetadata) {
  go();
  EXPECT_EQ(number(wait(45), PduKind::eof), 4U);
  EXPECT_TRUE(wait(10).empty());
  EXPECT_EQ(sender.phase(), SendPhase::resting);
  EXPECT_EQ(sender.counts().rests, 1U);
  const auto later = wait(60);
  EXPECT_EQ(number(later, PduKind::metadata), 1U);
  EXPECT_GE(number(later, PduKind::eof), 1U);
  EXPECT_EQ(sender.outcome(), SendOutcome::open);
  // An answer ends the silence.
  receive_nak({{0, 100}});
  EXPECT_EQ(go().size(), 1U);
  EXPECT_EQ(sender.counts().rests, 0U);
}

TEST_F(CfdpSenderTest, ATimeThatStandsStillRunsNoTimer) {
  go();
  for (int i = 0; i < 10000; ++i) {
    sender.tick(now);
    EXPECT_TRUE(go().empty());
  }
}

TEST_F(CfdpSenderTest, BehindTheAckOfTheEofNothingIsRepeatedUntilItRests) {
  go();
  receive_ack();
  EXPECT_TRUE(wait(50).empty());
  EXPECT_EQ(number(wait(65), PduKind::eof), 1U);
}

TEST_F(CfdpSenderTest, PromptsWhereTheMissionWantsIt) {
  settings.prompt_ns = 20 * ns_per_s;
  sender.begin(order, settings);
  go();
  receive_ack();
  EXPECT_GE(number(wait(45), PduKind::prompt), 1U);
  Pdu pdu;
  sender.build({PduKind::prompt, false, {}}, pdu);
  EXPECT_FALSE(pdu.prompt.keep_alive);
}

TEST_F(CfdpSenderTest, OneNakWithAsManyGapsAsItHoldsTakesStepsInProportion) {
  order.file_bytes = 100000;
  settings.segment_bytes = 1000;
  std::vector<Segment> held;
  for (std::uint32_t i = 0; i < limits::max_file_gaps; ++i) held.push_back({200 * i, 200 * i + 100});
  sender.resume(order, settings, 100000, true, held);
  std::vector<Gap> asked;
  for (std::uint64_t i = 0; i < 250; ++i) asked.push_back({200 * i + 50, 200 * i + 150});
  // As many as a step takes.
  for (int nak = 0; nak < 128; ++nak) receive_nak(asked);
  EXPECT_LE(sender.counts().gap_steps, 128U * 5U * (250U + limits::max_file_gaps));
}

TEST_F(CfdpSenderTest, AFinishedOfAnEarlierFileDeliversNothing) {
  go();
  // The receiver remembers the number: its answers are those of the file before.
  receive_finished();
  EXPECT_EQ(sender.outcome(), SendOutcome::open);
  auto items = go();
  ASSERT_EQ(items.size(), 1U) << "no acknowledgement: the EOF asks what there is";
  EXPECT_EQ(items[0].kind, PduKind::eof);
  receive_ack(TransactionStatus::terminated);
  receive_finished();
  EXPECT_EQ(sender.outcome(), SendOutcome::spent);
  // An ACK before the Finished gives it away, too.
  for (const TransactionStatus status :
       {TransactionStatus::undefined, TransactionStatus::terminated, TransactionStatus::unrecognized}) {
    sender.begin(order, settings);
    go();
    receive_ack(status);
    EXPECT_EQ(sender.outcome(), SendOutcome::spent);
  }
  // Who asks for more has not finished, whatever was said before.
  sender.begin(order, settings);
  go();
  receive_finished();
  receive_nak({{0, 100}});
  receive_ack();
  EXPECT_EQ(sender.outcome(), SendOutcome::open);
  receive_finished();
  EXPECT_EQ(sender.outcome(), SendOutcome::delivered);
}

TEST_F(CfdpSenderTest, AReceiverThatClosedAfterItsWorkIsHeardOnceMore) {
  go();
  receive_ack();
  receive_ack(TransactionStatus::terminated);
  EXPECT_EQ(sender.outcome(), SendOutcome::open) << "its Finished may come behind the ACK";
  receive_finished();
  EXPECT_EQ(sender.outcome(), SendOutcome::delivered);
  // If it never comes, the file is sent again instead of waiting without end.
  sender.begin(order, settings);
  go();
  receive_ack();
  receive_ack(TransactionStatus::terminated);
  wait(200);
  receive_ack(TransactionStatus::terminated);
  EXPECT_EQ(sender.outcome(), SendOutcome::spent);
}

TEST_F(CfdpSenderTest, AFinishedBeforeTheAckOfTheEofIsBelievedWithIt) {
  go();
  receive_finished();
  EXPECT_EQ(number(wait(10), PduKind::eof), 1U) << "at once";
  EXPECT_EQ(sender.outcome(), SendOutcome::open);
  receive_ack();
  EXPECT_EQ(sender.outcome(), SendOutcome::delivered);
  const auto items = go();
  ASSERT_EQ(items.size(), 1U);
  EXPECT_EQ(items[0].kind, PduKind::ack);
  EXPECT_TRUE(wait(100).empty());
  // Every Finished is acknowledged.
  receive_finished();
  EXPECT_EQ(go().size(), 1U);
}

TEST_F(CfdpSenderTest, OnlyCompleteAndRetainedWithoutErrorIsDelivered) {
  struct Case {
    Condition condition;
    bool incomplete;
    FileStatus status;
    SendOutcome outcome;
  };
  for (const Case& c : {Case{Condition::no_error, true, FileStatus::retained, SendOutcome::refused},
                        Case{Condition::no_error, false, FileStatus::discarded, SendOutcome::refused},
                        Case{Condition::no_error, false, FileStatus::unreported, SendOutcome::refused},
                        Case{Condition::no_error, false, FileStatus::rejected_by_filestore, SendOutcome::refused},
                        Case{Condition::file_checksum_failure, false, FileStatus::retained, SendOutcome::refused},
                        Case{Condition::nak_limit_reached, true, FileStatus::discarded, SendOutcome::refused},
                        Case{Condition::cancel_request_received, true, FileStatus::discarded, SendOutcome::cancelled},
                        Case{Condition::no_error, false, FileStatus::retained, SendOutcome::delivered}}) {
    sender.begin(order, settings);
    go();
    receive_ack();
    receive_finished(c.condition, c.incomplete, c.status);
    EXPECT_EQ(sender.outcome(), c.outcome);
    EXPECT_EQ(go().size(), 1U) << "acknowledged all the same";
  }
  // Before all of it has been sent, no station can hold it.
  sender.begin(order, settings);
  go(3);
  receive_finished();
  EXPECT_EQ(sender.outcome(), SendOutcome::refused);
}

TEST_F(CfdpSenderTest, SuspendsResumesAndCancels) {
  go(3);
  sender.suspend();
  EXPECT_TRUE(go().empty());
  EXPECT_TRUE(wait(1000).empty());
  sender.unsuspend(now);
  EXPECT_EQ(go(1).size(), 1U);
  sender.cancel(0xABCD, now);
  const auto items = go();
  ASSERT_EQ(items.size(), 1U);
  Pdu pdu;
  sender.build(items[0], pdu);
  EXPECT_EQ(pdu.eof.condition, Condition::cancel_request_received);
  EXPECT_EQ(pdu.eof.file_bytes, 200U);
  EXPECT_EQ(pdu.eof.checksum, 0xABCDU);
  std::span<const std::uint8_t> options = pdu.eof.options;
  Tlv tlv;
  ASSERT_TRUE(next_tlv(options, tlv));
  EXPECT_EQ(tlv.type, tlv_entity_id);
  receive_nak({{0, 100}});
  EXPECT_TRUE(go().empty()) << "nothing of the file any more";
  receive_ack();
  EXPECT_EQ(sender.outcome(), SendOutcome::cancelled);
  // Nobody answers: it ends by itself.
  sender.begin(order, settings);
  go();
  sender.cancel(0, now);
  wait(100);
  EXPECT_EQ(sender.outcome(), SendOutcome::cancelled);
}

TEST_F(CfdpSenderTest, GoesOnBehindARestart) {
  const Segment gaps[] = {{10, 20}, {150, 900}};
  sender.resume(order, settings, 200, false, gaps);
  auto items = go();
  ASSERT_EQ(items.size(), 6U);
  EXPECT_EQ(items[2].segment.begin, 10U);
  EXPECT_EQ(items[3].segment.end, 200U);
  EXPECT_EQ(items[4].segment.begin, 200U);
  EXPECT_EQ(items[5].kind, PduKind::eof);
  sender.resume(order, settings, 250, true, std::span(gaps).first(1));
  items = go();
  ASSERT_EQ(items.size(), 2U);
  EXPECT_EQ(items[1].kind, PduKind::eof);
}

TEST_F(CfdpSenderTest, AnyPdusLeaveItWithinItsBounds) {
  std::uint32_t random = 7;
  const auto next_random = [&] { return (random = random * 1664525U + 1013904223U) >> 8U; };
  for (int trial = 0; trial < 2000; ++trial) {
    sender.begin(order, settings);
    for (int i = 0; i < 40; ++i) {
      now += static_cast<TimeNs>(next_random() % 5) * ns_per_s;
      switch (next_random() % 8) {
        case 0:
          receive_nak({{next_random() % 300, next_random() % 300}, {next_random() % 300, next_random() % 300}});
          break;
        case 1:
          receive_ack();
          break;
        case 2:
          if (next_random() % 8 == 0)
            receive_finished(static_cast<Condition>(next_random() % 16), next_random() % 2,
                             static_cast<FileStatus>(next_random() % 4));
          break;
        case 3:
          next_random() % 2 == 0 ? sender.suspend() : sender.unsuspend(now);
          break;
        case 4:
          if (next_random() % 16 == 0) sender.cancel(1, now);
          break;
        default:
          sender.tick(now);
          for (const SendItem& item : go(next_random() % 4)) {
            EXPECT_LE(item.segment.begin, item.segment.end);
            EXPECT_LE(item.segment.end, order.file_bytes);
            EXPECT_LE(item.segment.end - item.segment.begin, settings.segment_bytes);
          }
      }
      EXPECT_EQ(sender.outcome() == SendOutcome::open, sender.phase() != SendPhase::closed);
    }
  }
}

}  // namespace
}  // namespace ilp::cfdp
