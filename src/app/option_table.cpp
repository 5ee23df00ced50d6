// SPDX-License-Identifier: Apache-2.0
#include "option.hpp"

#include <array>

namespace egomod {
namespace {

using namespace std::string_view_literals;

constexpr std::array kEgomotionMethods{"ispkf"sv, "gauss_newton"sv};
constexpr std::array kMovingObjectsMethods{"thesis"sv, "lag"sv, "filter"sv};
constexpr std::array kImageEncodings{"none"sv, "raw"sv, "jpeg"sv};
constexpr std::array kLogLevels{"debug"sv, "info"sv, "warning"sv, "error"sv};

// Macros, because only they turn a member into its key.
#define FIELD(member) \
  [](Config & c) -> auto& { return c.member; }
#define NUMBER(member, min, max, unit, help) \
  Option { #member, +FIELD(member), help, min, max, unit }
#define SWITCH(member, help) \
  Option { #member, +FIELD(member), help }
#define TEXT(member, help) \
  Option { #member, +FIELD(member), help }
#define CHOICE(member, names, help)                                                         \
  Option {                                                                                  \
#member,                                                                                  \
        Choice{[](const Config& c) { return static_cast<int>(c.member); },                    \
               [](Config& c, int value) { c.member = static_cast<decltype(c.member)>(value); }, \
               names},                                                                        \
        help \
  }

// clang-format off
constexpr Option kOptions[] = {
    TEXT(daemon.source, "Where stereo pairs come from: folder:DIR, log:FILE, lcm, sim[:WORLD]"),
    TEXT(daemon.rig, "Calibration file of the rig; empty: what the source brings along"),
    TEXT(daemon.lcm_url, "The bus; empty: $LCM_DEFAULT_URL, else udpm://239.255.76.67:7667?ttl=0"),
    TEXT(daemon.record, "LCM log to write, overwritten; empty: none"),
    SWITCH(daemon.record_timing, "Record EGOMOD_TIMING too, which is not deterministic"),

    NUMBER(capture.max_rate_hz, 0, 1000, "Hz", "Pairs a second that reach the features; 0: every pair"),
    NUMBER(capture.max_skew_s, 0, 10, "s", "Largest time between the exposures of a pair; 0: half a frame interval"),
    NUMBER(capture.wheels_max_age_s, 0, 10, "s", "Largest time between two messages of PIONEER_ODOMETRY, or since the last one, within which the wheels count"),
    TEXT(capture.left_channel, "bot_core.image_t channel of the left camera, for log and lcm; empty: EGOMOD_IMAGES"),
    TEXT(capture.right_channel, "The same of the right camera"),

    NUMBER(features.max_tracks, 0, 20000, "tracks", "Points followed at a time, 16 or more; 0: 1000 where the processor has AVX2, 550 where it has not"),
    NUMBER(features.max_disparity_share, 0.01, 1, "of the image width", "Disparities searched"),
    NUMBER(features.search_radius_share, 0.01, 1, "of the image width", "Search between two pairs when no motion is known"),

    CHOICE(egomotion.method, kEgomotionMethods, "Iterated sigma-point Kalman filter (thesis) or robust Gauss-Newton"),
    SWITCH(egomotion.map, "Against each track's position filtered over its life, instead of pair to pair"),
    NUMBER(egomotion.min_inliers, 3, 1000, "tracks", "Fewer inliers: the estimate has failed"),
    NUMBER(egomotion.min_inlier_share, 0, 1, "of the tracks", "A smaller share of inliers: the estimate has failed"),
    NUMBER(egomotion.max_translation_sigma_m, 0, 1000, "m", "Worst standard deviation of a translation still called determined"),
    NUMBER(egomotion.max_rotation_sigma_rad, 0, 10, "rad", "Worst standard deviation of a rotation still called determined"),
    NUMBER(egomotion.inlier_chi2, 0.1, 1000, "", "Gauss-Newton: squared Mahalanobis distance that parts inliers from outliers"),
    NUMBER(egomotion.reset_translation_sigma_m, 0, 1000, "m", "What a reset without knowledge of the motion adds to the pose"),
    NUMBER(egomotion.reset_rotation_sigma_rad, 0, 10, "rad", "The same for the rotation"),

    NUMBER(egomotion.ransac.max_samples, 1, 100000, "samples", "Minimal samples tried at most"),
    NUMBER(egomotion.ransac.threshold_px, 0.01, 100, "px", "Largest reprojection error of an inlier, Euclidean, over both images"),
    NUMBER(egomotion.ransac.confidence, 0, 0.999999, "", "Probability of at least one sample without outliers"),
    NUMBER(egomotion.ransac.seed, 0, 4294967295, "", "Of the sampling: the same seed draws the same samples"),

    NUMBER(egomotion.gauss_newton.max_iterations, 1, 1000, "iterations", "At most"),
    NUMBER(egomotion.gauss_newton.step_tolerance, 0, 1, "m or rad", "Largest component of a step that ends the iteration"),
    NUMBER(egomotion.gauss_newton.geman_mcclure_chi2, 0.1, 1000, "", "Squared Mahalanobis distance at which a weight is a quarter"),

    NUMBER(egomotion.sigma_point_filter.max_iterations, 1, 1000, "iterations", "At most"),
    NUMBER(egomotion.sigma_point_filter.step_tolerance, 0, 1, "posterior sigma", "Step that ends the iteration"),
    NUMBER(egomotion.sigma_point_filter.initial_speed_sigma_mps, 0.001, 1000, "m/s", "Standard deviation of the velocity before the first pair"),
    NUMBER(egomotion.sigma_point_filter.initial_turn_sigma_radps, 0.001, 100, "rad/s", "Standard deviation of the turn rate before the first pair"),
    NUMBER(egomotion.sigma_point_filter.acceleration_sigma_mps2, 0.001, 1000, "m/s^2", "Process noise of the constant velocity"),
    NUMBER(egomotion.sigma_point_filter.turn_acceleration_sigma_radps2, 0.001, 1000, "rad/s^2", "Process noise of the constant turn rate"),

    NUMBER(egomotion.track_map.fade_per_s, 1, 1000, "1/s", "Growth of a position's covariance while it ages"),
    NUMBER(egomotion.track_map.linear_updates, 0, 1000, "updates", "First updates of a track that are linear in space"),
    NUMBER(egomotion.track_map.max_distance2, 0, 10000, "", "Squared Mahalanobis distance from which an update is cut"),
    NUMBER(egomotion.track_map.distrust_rate, 0, 1, "a pair", "How fast a track that does not fit loses its weight"),
    NUMBER(egomotion.track_map.trust_rate, 0, 1, "a pair", "How fast one that fits regains it"),
    NUMBER(egomotion.track_map.reset_below_weight, 0, 1, "", "A track trusted less starts anew where it is seen"),

    NUMBER(egomotion.rival.min_support_ratio, 0, 1, "", "Support of a second motion, to that of the estimate alone, that makes it ambiguous"),
    NUMBER(egomotion.rival.ratio_to_stay, 0, 1, "", "The same once it is ambiguous"),
    NUMBER(egomotion.rival.overwhelming_ratio, 1, 1000, "", "A motion with so many times the other's support is the world's, whatever the past"),
    NUMBER(egomotion.rival.acceleration_sigma_mps2, 0.001, 1000, "m/s^2", "How a rig may change its velocity, to decide between the two"),
    NUMBER(egomotion.rival.turn_acceleration_sigma_radps2, 0.001, 1000, "rad/s^2", "How it may change its turn rate"),

    SWITCH(egomotion.wheels.enable, "PIONEER_ODOMETRY, if it comes, decides between motions that images leave open"),
    NUMBER(egomotion.wheels.sigma_per_m, 0, 10, "m/m", "What slip makes of the wheels' way, standard deviation"),
    NUMBER(egomotion.wheels.sigma_per_rad, 0, 10, "rad/rad", "The same of their turns"),

    CHOICE(moving_objects.method, kMovingObjectsMethods, "Two pairs, RANSAC outliers and a speed threshold (thesis), each pair against an earlier one, whitened (lag), or evidence from a standing and a moving filter of each track (filter)"),
    NUMBER(moving_objects.threshold_mps, 0, 100, "m/s", "thesis: a faster point moves; 0: from the Rayleigh scales below"),
    NUMBER(moving_objects.sigma_static_mps, 0.0001, 100, "m/s", "thesis: Rayleigh scale of the speeds of static points"),
    NUMBER(moving_objects.sigma_moving_mps, 0.0001, 100, "m/s", "thesis: Rayleigh scale of the speeds of moving points"),
    NUMBER(moving_objects.prior_moving, 0.000001, 0.999999, "", "thesis: share of points that move, before seeing them"),
    NUMBER(moving_objects.decision_probability, 0.000001, 0.999999, "", "thesis: posterior from which a point moves, when threshold_mps is 0"),
    NUMBER(moving_objects.velocity_bin_mps, 0.001, 100, "m/s", "thesis: each velocity component is rounded to a multiple of this"),
    NUMBER(moving_objects.velocity_bin_reach, 0, 100, "bins", "thesis: velocities no further apart in any component are the same"),
    NUMBER(moving_objects.group_distance_m, 0.001, 100, "m", "thesis: points nearer than this belong together"),
    NUMBER(moving_objects.group_min_points, 1, 1000, "points", "thesis: smallest group"),
    NUMBER(moving_objects.lag_s, 0.001, 10, "s", "lag: age of the pair compared with"),
    NUMBER(moving_objects.min_lag_s, 0, 10, "s", "lag: its least age"),
    NUMBER(moving_objects.max_lag_s, 0.001, 10, "s", "lag: its greatest age"),
    NUMBER(moving_objects.moving_chi2, 0, 10000, "", "lag: whitened squared displacement (3 dof) from which a point may move"),
    NUMBER(moving_objects.static_chi2, 0, 10000, "", "lag: and below which it is static"),
    NUMBER(moving_objects.min_speed_mps, 0, 100, "m/s", "lag: least speed of a moving point"),
    NUMBER(moving_objects.max_depth_m, 0.1, 1000, "m", "lag, filter: points further away are left out"),
    NUMBER(moving_objects.noise_floor_px, 0, 10, "px", "lag, filter: added to each observation's standard deviation, for the drift of tracks"),
    NUMBER(moving_objects.disparity_bias_px, 0, 10, "px", "lag, filter: disparity error that a point keeps over the lag, and that feigns motion in proportion to the rig's own"),
    NUMBER(moving_objects.flow_error_share, 0, 1, "of the path's length", "lag, filter: systematic error of a static point's path through the image"),
    NUMBER(moving_objects.velocity_prior_mps, 0.001, 100, "m/s", "lag, filter: standard deviation of movers' speed along each axis, before seeing them"),
    NUMBER(moving_objects.neighbour_distance_m, 0, 100, "m", "lag, filter: neighbours in an object are nearer than this across the line of sight"),
    NUMBER(moving_objects.neighbour_distance_px, 0, 10000, "px", "lag, filter: or nearer than this in the image"),
    NUMBER(moving_objects.neighbour_depth_m, 0, 100, "m", "lag, filter: and nearer than this along it, plus 2.5 sigma of both depths"),
    NUMBER(moving_objects.min_points, 1, 1000, "points", "lag, filter: smallest object"),
    NUMBER(moving_objects.min_purity, 0, 1, "of the tracks", "lag, filter: least share of the tracks inside an object's rectangle and depth that move"),
    NUMBER(moving_objects.error_correlation, 0, 1, "", "lag, filter: correlation of the errors of an object's points"),
    NUMBER(moving_objects.object_chi2, 0, 10000, "", "lag, filter: least chi-square of an object's mean velocity"),
    NUMBER(moving_objects.confirm_pairs, 1, 1000, "pairs", "lag: evidence in this many pairs makes a new object MOVING"),
    NUMBER(moving_objects.confirm_s, 0, 100, "s", "lag: over at least this time"),
    NUMBER(moving_objects.coast_s, 0, 100, "s", "lag, filter: how long an object coasts without evidence"),
    NUMBER(moving_objects.acceleration_mps2, 0.001, 100, "m/s^2", "filter: process noise of a mover's velocity"),
    NUMBER(moving_objects.manoeuvre_hz, 0, 100, "1/s", "filter: and in proportion to its speed"),
    NUMBER(moving_objects.walk_px, 0, 10, "px", "filter: a track strays this far in the left image from pair to pair"),
    NUMBER(moving_objects.min_evidence, 0, 10000, "", "filter: log likelihood ratio of a group from which it becomes an object"),
    NUMBER(moving_objects.confirm_evidence, 0, 10000, "", "filter: and, as a leaky sum over pairs, MOVING"),

    CHOICE(publish.images, kImageEncodings, "EGOMOD_IMAGES: the rectified pairs"),
    NUMBER(publish.jpeg_quality, 1, 100, "", "Of EGOMOD_IMAGES as jpeg"),
    SWITCH(publish.tracks, "EGOMOD_TRACKS, for viewers"),

    NUMBER(pipeline.slots, 6, 256, "frames", "Frames in flight, filled in place"),
    SWITCH(pipeline.single_thread, "All stages in order on one thread, with the priority and the CPU of capture"),
    SWITCH(pipeline.realtime, "Replays paced by exposure time; pairs that come too late are dropped as from a camera"),
    NUMBER(pipeline.realtime_priority, 0, 99, "", "SCHED_FIFO priority of capture, one less for each later stage; 0: off"),
    TEXT(pipeline.cpus, "One CPU for all stages or one for each, in order: \"2,3,4,5,5\"; empty: any"),
    SWITCH(pipeline.lock_memory, "Keep the daemon in memory (mlockall)"),

    CHOICE(logging.level, kLogLevels, "Least severity that is logged"),
    NUMBER(logging.repeat_s, 0, 3600, "s", "A warning that repeats is logged at most once in this time, with a count"),
};
// clang-format on

#undef FIELD
#undef NUMBER
#undef SWITCH
#undef TEXT
#undef CHOICE

}  // namespace

std::span<const Option> options() { return kOptions; }

}  // namespace egomod
