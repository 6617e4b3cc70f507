#include "fsw/vision/place/place_index.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "fsw/base/argument.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/place/descriptor_distance.hpp"

namespace ilp {
namespace {

constexpr int max_signature_bits = 18;
// Lists that are longer than the mean times this tell little.
constexpr std::size_t max_list_ratio = 4;
constexpr std::size_t min_long_list = 64;
constexpr int most_votes = 30000;  // of one difference; two neighbours are added
constexpr std::int32_t max_level_step = static_cast<std::int32_t>(PlaceQueryWorkspace::level_steps / 2);

// Which of `count` features is the one with number k of `kept`, evenly.
std::size_t chosen(std::size_t k, std::size_t kept, std::size_t count) {
  return k * count / kept;
}

}  // namespace

void PlaceIndex::clear() {
  entries_.fill({});
  word_begin_.fill(0);
  vocabulary_.fill({});
  is_word_.fill(0);
  first_descriptors_.fill({});
  first_words_.fill({});
  first_counts_.fill(0);
  keyframes_.fill(0);
  taken_.fill(0);
  entry_count_ = places_ = first_places_ = 0;
}

bool PlaceIndex::lists_are_valid() const {
  bool valid = word_begin_[0] == 0 && word_begin_.back() == entry_count_ && entry_count_ <= max_entries &&
               first_places_ <= limits::place_vocabulary_places;
  for (std::size_t w = 0; w < limits::place_vocabulary; ++w) valid = valid && word_begin_[w] <= word_begin_[w + 1];
  for (const std::uint16_t count : first_counts_) valid = valid && count <= limits::indexed_place_features;
  return valid;
}

std::uint16_t PlaceIndex::nearest_word(const Descriptor& descriptor) const {
  int best = 257;
  std::uint16_t word = 0;
  with_known_vectors([&](auto vectors) {
    for (std::size_t w = 0; w < limits::place_vocabulary; ++w) {
      const int distance = hamming_256_with(vectors, descriptor.bits, vocabulary_[w].bits);
      if (distance < best && is_word_[w] != 0) {
        best = distance;
        word = static_cast<std::uint16_t>(w);
      }
    }
  });
  return word;
}

PlaceIndex::NearestWords PlaceIndex::nearest_words(const PlaceFeature& feature) const {
  std::array<int, words_per_feature> distances;
  NearestWords words{};
  distances.fill(257);
  with_known_vectors([&](auto vectors) {
    for (std::size_t w = 0; w < limits::place_vocabulary; ++w) {
      const int distance = hamming_256_with(vectors, feature.descriptor, vocabulary_[w].bits);
      if (distance >= distances.back() || is_word_[w] == 0) continue;
      std::size_t at = words_per_feature - 1;
      for (; at > 0 && distance < distances[at - 1]; --at) {
        distances[at] = distances[at - 1];
        words[at] = words[at - 1];
      }
      distances[at] = distance;
      words[at] = static_cast<std::uint16_t>(w);
    }
  });
  return words;
}

Status PlaceIndex::insert(std::size_t slot, std::int64_t keyframe_id, std::span<const PlaceFeature> features) {
  if (slot >= limits::max_places) return out_of_range(Argument::slot, slot);
  if (taken_[slot] != 0) return out_of_range(Argument::slot, slot);
  ILP_ASSERT(lists_are_valid(), entry_count_);
  const bool first = slot < limits::place_vocabulary_places;
  if (!first && !has_vocabulary()) return StatusCode::not_ready;

  const std::size_t kept = std::min(features.size(), limits::indexed_place_features);
  ILP_ASSERT(entry_count_ + kept <= max_entries, entry_count_);
  NewEntry added[limits::indexed_place_features];
  for (std::size_t k = 0; k < kept; ++k) {
    const PlaceFeature& feature = features[chosen(k, kept, features.size())];
    Descriptor descriptor;
    std::copy_n(feature.descriptor, descriptor_words, descriptor.bits);
    added[k] = {
        {{descriptor.bits[0], descriptor.bits[1]}, static_cast<std::uint16_t>(slot), feature.angle, feature.level}, 0};
    if (first) {
      first_descriptors_[slot * limits::indexed_place_features + k] = descriptor;
    } else {
      added[k].word = nearest_word(descriptor);
    }
  }
  insert_entries({added, kept});
  keyframes_[slot] = keyframe_id;
  taken_[slot] = 1;
  ++places_;
  if (first) take_words(slot, kept);
  return {};
}

// Moves the entries behind each new one by as many places as there are new ones before them, from the end.
void PlaceIndex::insert_entries(std::span<NewEntry> added) {
  const auto before = [](const NewEntry& p, const NewEntry& q) { return p.word < q.word; };
  // Insertion sort keeps the features of one word in order.
  for (std::size_t i = 1; i < added.size(); ++i) {
    const NewEntry entry = added[i];
    std::size_t k = i;
    for (; k > 0 && before(entry, added[k - 1]); --k) added[k] = added[k - 1];
    added[k] = entry;
  }
  std::uint32_t end = entry_count_;
  for (std::size_t i = added.size(); i > 0; --i) {
    const NewEntry& entry = added[i - 1];
    // Behind `end` entries have moved already. The entry of a word with more than one goes before those.
    const Entry* const list = entries_.data() + word_begin_[entry.word];
    const Entry* const list_end = entries_.data() + std::min(word_begin_[entry.word + std::size_t{1}], end);
    const Entry* const after = std::upper_bound(list, list_end, entry.entry.slot,
                                                [](std::uint16_t slot, const Entry& e) { return slot < e.slot; });
    const auto at = static_cast<std::uint32_t>(after - entries_.data());
    std::copy_backward(entries_.begin() + at, entries_.begin() + end, entries_.begin() + end + i);
    entries_[at + i - 1] = entry.entry;
    end = at;
  }
  std::uint32_t moved = 0;
  for (std::size_t w = 0; w <= limits::place_vocabulary; ++w) {
    word_begin_[w] += moved;
    while (moved < added.size() && added[moved].word == w) ++moved;
  }
  entry_count_ += static_cast<std::uint32_t>(added.size());
}

// The word of an entry is the nearest one, of equal ones that with the lowest number: in whatever order they come.
void PlaceIndex::take_words(std::size_t slot, std::size_t kept) {
  constexpr std::size_t stride = limits::indexed_place_features;
  const std::size_t first_word = slot * words_of_place, words = std::min(words_of_place, kept);
  for (std::size_t k = 0; k < words; ++k) {
    vocabulary_[first_word + k] = first_descriptors_[slot * stride + chosen(k, words, kept)];
    is_word_[first_word + k] = 1;
  }
  first_counts_[slot] = static_cast<std::uint16_t>(kept);
  ++first_places_;
  const auto compare = [&](auto vectors, std::size_t entry, std::size_t begin, std::size_t end) {
    NearWord& nearest = first_words_[entry];
    for (std::size_t w = begin; w < end; ++w) {
      if (is_word_[w] == 0) continue;
      const int distance = hamming_256_with(vectors, first_descriptors_[entry].bits, vocabulary_[w].bits);
      const NearWord found{static_cast<std::uint16_t>(distance), static_cast<std::uint16_t>(w)};
      if (found.distance < nearest.distance || (found.distance == nearest.distance && found.word < nearest.word)) {
        nearest = found;
      }
    }
  };
  with_known_vectors([&](auto vectors) {
    for (std::size_t k = 0; k < kept; ++k) {
      first_words_[slot * stride + k] = {257, 0};
      compare(vectors, slot * stride + k, 0, limits::place_vocabulary);
    }
    for (std::size_t s = 0; s < limits::place_vocabulary_places; ++s) {
      if (s == slot) continue;
      for (std::size_t k = 0; k < first_counts_[s]; ++k) {
        compare(vectors, s * stride + k, first_word, first_word + words);
      }
    }
  });
  if (has_vocabulary()) sort_first_entries();
}

// Until now they are one list in order of slot and feature. Counting sort; the free part of the entries takes the copy.
void PlaceIndex::sort_first_entries() {
  static_assert(max_entries >= 2 * first_entries);
  Entry* const copy = entries_.data() + first_entries;
  const std::size_t count = std::min<std::size_t>(entry_count_, first_entries);
  std::copy_n(entries_.begin(), count, copy);
  word_begin_.fill(0);
  const auto each = [this](auto&& use) {
    std::size_t from = 0;
    for (std::size_t s = 0; s < limits::place_vocabulary_places; ++s) {
      for (std::size_t k = 0; k < first_counts_[s]; ++k, ++from) {
        const std::size_t word = first_words_[s * limits::indexed_place_features + k].word;
        use(std::min(word, limits::place_vocabulary - 1), from);
      }
    }
  };
  each([this](std::size_t word, std::size_t) { ++word_begin_[word + 1]; });
  for (std::size_t w = 0; w < limits::place_vocabulary; ++w) word_begin_[w + 1] += word_begin_[w];
  each([&](std::size_t word, std::size_t from) { entries_[word_begin_[word]++] = copy[from]; });
  // Each is now the beginning of the next one.
  std::copy_backward(word_begin_.begin(), word_begin_.end() - 1, word_begin_.end());
  word_begin_[0] = 0;
  std::fill_n(copy, count, Entry{});
}

Status PlaceIndex::remove(std::size_t slot) {
  if (slot >= limits::max_places || slot < limits::place_vocabulary_places) {
    return out_of_range(Argument::slot, slot);
  }
  if (taken_[slot] == 0) return {StatusCode::not_found, static_cast<std::int64_t>(slot)};
  ILP_ASSERT(lists_are_valid(), entry_count_);
  std::uint32_t kept = 0;
  std::uint32_t from = 0;
  for (std::size_t w = 0; w < limits::place_vocabulary; ++w) {
    const std::uint32_t end = word_begin_[w + 1];
    for (; from < end; ++from) {
      if (entries_[from].slot != slot) entries_[kept++] = entries_[from];
    }
    word_begin_[w + 1] = kept;
  }
  std::fill(entries_.begin() + kept, entries_.begin() + entry_count_, Entry{});
  entry_count_ = kept;
  keyframes_[slot] = 0;
  taken_[slot] = 0;
  --places_;
  return {};
}

void PlaceIndex::collect(const PlaceFeature& feature, std::size_t word, std::int64_t excluding_from_id,
                         PlaceQueryWorkspace& w) const {
  const std::uint64_t signature = feature.descriptor[0] | std::uint64_t{feature.descriptor[1]} << 32;
  for (std::uint32_t e = word_begin_[word]; e < word_begin_[word + std::size_t{1}]; ++e) {
    const Entry& entry = entries_[e];
    const std::uint64_t other = entry.signature[0] | std::uint64_t{entry.signature[1]} << 32;
    const int distance = count_ones(signature ^ other);
    if (distance > max_signature_bits || feature.level > entry.level + max_level_step ||
        entry.level > feature.level + max_level_step)
      continue;
    if (!holds(entry.slot) || keyframes_[entry.slot] >= excluding_from_id) continue;
    // When there is no room for more, the feature tells next to nothing.
    (void)w.alike.push_back({e, distance});
  }
}

void PlaceIndex::collect(const PlaceFeature& feature, std::int64_t excluding_from_id, PlaceQueryWorkspace& w) const {
  w.alike.clear();
  if (!has_vocabulary()) return collect(feature, 0, excluding_from_id, w);
  const std::size_t longest = std::max(min_long_list, max_list_ratio * entry_count_ / limits::place_vocabulary);
  for (const std::uint16_t word : nearest_words(feature)) {
    if (word_begin_[word + std::size_t{1}] - word_begin_[word] <= longest) {
      collect(feature, word, excluding_from_id, w);
    }
  }
}

void PlaceIndex::vote(const PlaceFeature& feature, PlaceQueryWorkspace& w) const {
  // What is found in many places tells little of any.
  const double rarity = 1 / std::sqrt(1.0 + static_cast<double>(w.alike.size()));
  for (const PlaceQueryWorkspace::Alike& alike : w.alike) {
    const Entry& entry = entries_[alike.entry];
    const std::int32_t levels_apart = feature.level - entry.level + max_level_step;
    const auto step = static_cast<std::size_t>(levels_apart);
    const auto rotation = static_cast<std::uint8_t>(feature.angle - entry.angle);
    std::uint16_t& votes = w.votes[entry.slot][step][rotation / (256 / PlaceQueryWorkspace::rotations)];
    const int nearness = max_signature_bits + 2 - alike.distance;
    votes = static_cast<std::uint16_t>(std::min(votes + static_cast<int>(rarity * nearness * nearness), most_votes));
  }
}

namespace {

/// The most votes for one rotation, which may lie between two of them, and one step of levels.
int most_for_one_view(const PlaceQueryWorkspace::PlaceVotes& votes) {
  int most = 0;
  for (std::size_t step = 0; step < PlaceQueryWorkspace::level_steps; ++step) {
    for (std::size_t r = 0; r < PlaceQueryWorkspace::rotations; ++r) {
      most = std::max(most, votes[step][r] + votes[step][(r + 1) % PlaceQueryWorkspace::rotations]);
    }
  }
  return most;
}

/// Candidates are in order of their votes, the earlier slot first.
void insert_by_votes(const PlaceCandidate& candidate, PlaceCandidates& best) {
  if (best.full()) {
    if (best.back().votes >= candidate.votes) return;
    best.pop_back();
  }
  std::size_t at = best.size();
  if (!best.push_back(candidate)) return;
  for (; at > 0 && best[at - 1].votes < candidate.votes; --at) best[at] = best[at - 1];
  best[at] = candidate;
}

}  // namespace

void PlaceIndex::rank(const PlaceQueryWorkspace& w, PlaceCandidates& best) const {
  for (std::size_t slot = 0; slot < limits::max_places; ++slot) {
    if (taken_[slot] == 0) continue;
    const int most = most_for_one_view(w.votes[slot]);
    if (most > 0)
      insert_by_votes({keyframes_[slot], static_cast<std::uint16_t>(slot), static_cast<std::uint16_t>(most)}, best);
  }
}

Status PlaceIndex::query(std::span<const PlaceFeature> features, std::int64_t excluding_from_id, PlaceQueryWorkspace& w,
                         PlaceCandidates& best) const {
  best.clear();
  ILP_ASSERT(lists_are_valid(), entry_count_);
  std::memset(&w.votes, 0, sizeof w.votes);
  for (const PlaceFeature& feature : features) {
    collect(feature, excluding_from_id, w);
    vote(feature, w);
  }
  rank(w, best);
  return {};
}

}  // namespace ilp
