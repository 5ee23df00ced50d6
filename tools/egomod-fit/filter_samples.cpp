// SPDX-License-Identifier: Apache-2.0
#include "filter_samples.hpp"

#include <algorithm>
#include <cstdint>
#include <map>

#include "egomod/moving_objects/evidence_gates.hpp"
#include "labels.hpp"
#include "point_truth.hpp"
#include "record_labels.hpp"
#include "track_record.hpp"

namespace egomod::fit {
namespace {

struct ObjectLife {
  int on_movers = 0, on_still = 0;  // moving points, over all pairs
  double most_in_pair = 0.0, sum = 0.0, most_summed = 0.0;
};

// The moving points of one object in one pair.
struct Group {
  double evidence = 0.0;
  std::size_t count = 0;
};

class Labeller {
 public:
  Labeller(const eval::Truth& truth, double error_correlation, FilterSamples& samples)
      : truth_(truth), error_correlation_(error_correlation), samples_(samples) {}

  void add(const TrackedPair& pair) {
    std::map<std::int64_t, Group> groups;
    for (const track_t& track : pair.list.tracks) {
      if (!(track.chi2 > 0.0F) || !(track.disparity > 0.0F)) continue;
      const auto moves = truth_.moves(pair.point(track));
      if (moves) add(pair, track, *moves);
      if (track.state != track_t::STATE_MOVING || track.object_id == 0) continue;
      Group& group = groups[track.object_id];
      group.evidence += track.evidence;
      ++group.count;
      if (moves) ++(*moves ? lives_[track.object_id].on_movers : lives_[track.object_id].on_still);
    }
    for (const auto& [id, group] : groups) add(group, lives_[id]);
  }

  void finish() const {
    for (const auto& [id, life] : lives_) {
      if (life.on_movers == life.on_still) continue;
      const bool moves = life.on_movers > life.on_still;
      samples_.pair_evidence.add(moves, life.most_in_pair);
      samples_.summed_evidence.add(moves, life.most_summed);
    }
  }

 private:
  void add(const TrackedPair& pair, const track_t& track, bool moves) {
    samples_.evidence.add(moves, track.evidence);
    samples_.chi2.add(moves, track.chi2);
    const bool decided = track.state == track_t::STATE_MOVING;
    samples_.decided.true_positives += moves && decided ? 1U : 0U;
    samples_.decided.false_positives += !moves && decided ? 1U : 0U;
    samples_.decided.false_negatives += moves && !decided ? 1U : 0U;
    if (!moves || !decided) return;
    const double speed_mps = pair.point(track).speed_mps;
    const double variance = speed_mps * speed_mps / 3.0 - pair.rig_speed_mps * pair.rig_speed_mps;
    ++samples_.velocities;
    samples_.velocity_variance_m2ps2 +=
        (variance - samples_.velocity_variance_m2ps2) / static_cast<double>(samples_.velocities);
  }

  void add(const Group& group, ObjectLife& life) const {
    const double evidence = group_evidence(group.evidence, group.count, error_correlation_);
    life.sum = add_evidence(life.sum, evidence);
    life.most_in_pair = std::max(life.most_in_pair, evidence);
    life.most_summed = std::max(life.most_summed, life.sum);
  }

  eval::PointTruth truth_;
  double error_correlation_;
  FilterSamples& samples_;
  std::map<std::int64_t, ObjectLife> lives_;
};

}  // namespace

void FilterSamples::sort() {
  for (ClassValues* values : {&evidence, &chi2, &pair_evidence, &summed_evidence}) values->sort();
}

std::string add_record(const std::string& log, const std::string& truth_folder,
                       double error_correlation, FilterSamples& samples) {
  const eval::Truth truth = read_object_truth(truth_folder);
  const std::size_t before = samples.evidence.still.size() + samples.evidence.moving.size();
  Labeller labeller(truth, error_correlation, samples);
  std::string damage =
      for_each_tracked_pair(log, [&](const TrackedPair& pair) { labeller.add(pair); });
  labeller.finish();
  if (samples.evidence.still.size() + samples.evidence.moving.size() == before) {
    throw InputError(log + ": no track carries evidence; record with moving_objects.method = " +
                     "\"filter\", the default");
  }
  return damage;
}

}  // namespace egomod::fit
