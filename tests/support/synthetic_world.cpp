// SPDX-License-Identifier: Apache-2.0
#include "synthetic_world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace egomod::test_support {
namespace {

constexpr int kSupersampling = 2;
constexpr int kMaxProbes = 4;
constexpr double kNear_m = 0.05;
constexpr double kDifference_s = 1e-4;

// For the ray through raster position (x, y, 1), H * (x, y, 1) = (s, t, 1) / depth: a patch covers
// the ray where all of s, t, 1 - s, 1 - t and depth are positive, five inequalities linear in x.
struct RasterPatch {
  Eigen::Matrix3d H;
  const Patch* patch = nullptr;
  const Texture* texture = nullptr;
  int body_id = 0;
};

struct Sample {
  float inverse_depth = 0.0F;
  std::int32_t patch = -1;
};

// A grid of samples; sample (i, j) looks through pixel (offset + i * step, offset + j * step).
struct Raster {
  int width = 0;
  int height = 0;
  double offset_px = 0.0;
  double step_px = 1.0;
  std::vector<Sample> samples;

  Raster(const StereoCamera& camera, int samples_per_px)
      : width(camera.width_px * samples_per_px),
        height(camera.height_px * samples_per_px),
        offset_px(0.5 / samples_per_px - 0.5),
        step_px(1.0 / samples_per_px),
        samples(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

  [[nodiscard]] Eigen::Matrix3d ray_of_sample(const StereoCamera& camera) const {
    Eigen::Matrix3d A;
    A << step_px / camera.fx_px, 0, (offset_px - camera.cx_px) / camera.fx_px,  //
        0, step_px / camera.fy_px, (offset_px - camera.cy_px) / camera.fy_px,   //
        0, 0, 1;
    return A;
  }
};

std::vector<RasterPatch> to_raster(const Scene& scene, double t_s,
                                   const Eigen::Isometry3d& T_camera_world,
                                   const Eigen::Matrix3d& ray_of_sample) {
  std::vector<RasterPatch> out;
  for (const Body& body : scene.bodies) {
    const Eigen::Isometry3d T = T_camera_world * body.T_world_body(t_s);
    for (const Patch& patch : body.patches) {
      Eigen::Matrix3d M;
      M << T.linear() * patch.edge_s_m, T.linear() * patch.edge_t_m, T * patch.corner_m;
      if (std::abs(M.determinant()) < 1e-12) continue;  // seen edge on
      out.push_back(
          {M.inverse() * ray_of_sample, &patch, &scene.textures.at(patch.texture), body.id});
    }
  }
  return out;
}

// Narrows [first, last], first >= 0, to where a + b x >= 0.
void clip(double a, double b, double& first, double& last) {
  if (b > 0.0) {
    first = std::max(first, -a / b);
  } else if (b < 0.0) {
    last = std::min(last, -a / b);
  } else if (a < 0.0) {
    last = -1.0;
  }
}

void rasterise_row(const RasterPatch& patch, std::int32_t index, int y, Raster& raster) {
  const Eigen::Vector3d g0 = patch.H.col(1) * y + patch.H.col(2);
  const Eigen::Vector3d gx = patch.H.col(0);
  double first = 0.0;
  double last = raster.width - 1.0;
  clip(g0[0], gx[0], first, last);
  clip(g0[1], gx[1], first, last);
  clip(g0[2] - g0[0], gx[2] - gx[0], first, last);
  clip(g0[2] - g0[1], gx[2] - gx[1], first, last);
  clip(g0[2] - 1e-6, gx[2], first, last);
  clip(1.0 / kNear_m - g0[2], -gx[2], first, last);
  if (!(first <= last)) return;
  Sample* row = raster.samples.data() + static_cast<std::ptrdiff_t>(y) * raster.width;
  for (int x = static_cast<int>(std::ceil(first)); x <= static_cast<int>(std::floor(last)); ++x) {
    const auto inverse_depth = static_cast<float>(g0[2] + gx[2] * x);
    if (inverse_depth > row[x].inverse_depth) row[x] = {inverse_depth, index};
  }
}

void rasterise(const std::vector<RasterPatch>& patches, Raster& raster) {
  for (std::size_t i = 0; i < patches.size(); ++i) {
    for (int y = 0; y < raster.height; ++y) {
      rasterise_row(patches[i], static_cast<std::int32_t>(i), y, raster);
    }
  }
}

// How a sample's square lies on the texture: trilinear probes spread along its longer axis.
struct Footprint {
  int probes = 1;
  float lod = 0.0F;
  Eigen::Array2f along = Eigen::Array2f::Zero();  // texels
};

Eigen::Array2f size_texels(const RasterPatch& patch) {
  return {static_cast<float>(patch.texture->width_texels()),
          static_cast<float>(patch.texture->height_texels())};
}

Eigen::Vector3f texture_ray(const RasterPatch& patch, int x, int y) {
  return (patch.H.col(0) * x + patch.H.col(1) * y + patch.H.col(2)).cast<float>();
}

Footprint footprint(const RasterPatch& patch, int x, int y) {
  const Eigen::Matrix3f H = patch.H.cast<float>();
  const Eigen::Vector3f g = texture_ray(patch, x, y);
  const Eigen::Array2f st = g.head<2>().array() / g[2];
  const Eigen::Array2f scale = size_texels(patch) / g[2];
  const Eigen::Array2f dx = (H.col(0).head<2>().array() - st * H(2, 0)) * scale;
  const Eigen::Array2f dy = (H.col(1).head<2>().array() - st * H(2, 1)) * scale;
  const float length_x = dx.matrix().norm();
  const float length_y = dy.matrix().norm();
  const float major = std::max({length_x, length_y, 1e-3F});
  const float minor = std::max(std::min(length_x, length_y), 1e-3F);
  const int probes = std::clamp(static_cast<int>(std::ceil(major / minor)), 1, kMaxProbes);
  return {probes, std::log2(std::max(major / static_cast<float>(probes), minor)),
          length_x > length_y ? dx : dy};
}

float shade(const RasterPatch& patch, const Footprint& print, int x, int y) {
  const Eigen::Vector3f g = texture_ray(patch, x, y);
  const Eigen::Array2f centre = g.head<2>().array() / g[2] * size_texels(patch) - 0.5F;
  const auto probes = static_cast<float>(print.probes);
  float sum = 0.0F;
  for (int i = 0; i < print.probes; ++i) {
    const float offset = (static_cast<float>(i) + 0.5F) / probes - 0.5F;
    const Eigen::Array2f at = centre + print.along * offset;
    sum += patch.texture->sample(at[0], at[1], print.lod);
  }
  return sum / probes * static_cast<float>(patch.patch->brightness);
}

std::uint64_t mixed(std::uint64_t x) {  // splitmix64's finaliser (Steele, Lea, Flood 2014)
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

// Near Gaussian, unit variance: the sum of four uniform 16-bit numbers.
float unit_noise(std::uint64_t key) {
  const std::uint64_t bits = mixed(key);
  const auto sum =
      (bits & 0xFFFFU) + (bits >> 16U & 0xFFFFU) + (bits >> 32U & 0xFFFFU) + (bits >> 48U);
  return (static_cast<float>(sum) / 65535.0F - 2.0F) * std::sqrt(3.0F);
}

float mean_of_pixel(const std::vector<RasterPatch>& patches, const Raster& raster, int u, int v) {
  float sum = 0.0F;
  std::int32_t last_patch = -1;
  Footprint print;
  for (int y = v * kSupersampling; y < (v + 1) * kSupersampling; ++y) {
    const Sample* row = raster.samples.data() + static_cast<std::ptrdiff_t>(y) * raster.width;
    for (int x = u * kSupersampling; x < (u + 1) * kSupersampling; ++x) {
      if (row[x].patch < 0) continue;
      const RasterPatch& patch = patches[static_cast<std::size_t>(row[x].patch)];
      if (row[x].patch != last_patch) print = footprint(patch, x, y);
      last_patch = row[x].patch;
      sum += shade(patch, print, x, y);
    }
  }
  return sum / (kSupersampling * kSupersampling);
}

// Pixels that the body would show if it were alone.
int count_alone(const Scene& scene, const Body& body, double t_s,
                const Eigen::Isometry3d& T_camera_world, const StereoCamera& camera) {
  Raster raster(camera, 1);
  std::vector<RasterPatch> own;
  for (const RasterPatch& patch :
       to_raster(scene, t_s, T_camera_world, raster.ray_of_sample(camera))) {
    if (patch.body_id == body.id) own.push_back(patch);
  }
  rasterise(own, raster);
  return static_cast<int>(std::count_if(raster.samples.begin(), raster.samples.end(),
                                        [](const Sample& sample) { return sample.patch >= 0; }));
}

}  // namespace

BodyMotion motion_of(const Trajectory& T_world_body, double t_s, const Eigen::Vector3d& P_world_m) {
  const Eigen::Isometry3d before = T_world_body(t_s - kDifference_s);
  const Eigen::Isometry3d after = T_world_body(t_s + kDifference_s);
  const Eigen::Vector3d P_body_m = T_world_body(t_s).inverse() * P_world_m;
  const Eigen::AngleAxisd turn(after.linear() * before.linear().transpose());
  return {(after * P_body_m - before * P_body_m) / (2.0 * kDifference_s),
          turn.axis() * (turn.angle() / (2.0 * kDifference_s))};
}

void grow(ObjectTruth& truth, int u, int v) {
  const bool first = truth.visible_px == 0;
  truth.u_min_px = first ? u : std::min(truth.u_min_px, u);
  truth.v_min_px = first ? v : std::min(truth.v_min_px, v);
  truth.u_max_px = first ? u : std::max(truth.u_max_px, u);
  truth.v_max_px = first ? v : std::max(truth.v_max_px, v);
  ++truth.visible_px;
}

SyntheticWorld::SyntheticWorld(Scene scene, const StereoCamera& camera,
                               const RenderOptions& options)
    : scene_(std::move(scene)), camera_(camera), options_(options) {}

void SyntheticWorld::render(double t_s, Image& left, Image& right) const {
  const Eigen::Isometry3d T_left_world = scene_.T_world_camera(t_s).inverse();
  render_eye(t_s, T_left_world, 0, left);
  render_eye(t_s, Eigen::Translation3d(-camera_.baseline_m, 0, 0) * T_left_world, 1, right);
}

void SyntheticWorld::render_eye(double t_s, const Eigen::Isometry3d& T_camera_world,
                                std::uint32_t eye, Image& out) const {
  Raster raster(camera_, kSupersampling);
  const auto patches = to_raster(scene_, t_s, T_camera_world, raster.ray_of_sample(camera_));
  rasterise(patches, raster);
  out.resize(camera_.width_px, camera_.height_px);
  const auto frame_key =
      mixed(static_cast<std::uint64_t>(std::llround(t_s * 1e6)) * 2 + eye) ^ mixed(options_.seed);
  std::uint64_t key = frame_key;
  for (int v = 0; v < camera_.height_px; ++v) {
    for (int u = 0; u < camera_.width_px; ++u) {
      float grey = mean_of_pixel(patches, raster, u, v);
      if (options_.noise_sigma > 0.0) {
        grey += static_cast<float>(options_.noise_sigma) * unit_noise(key++);
      }
      out.row(v)[u] = static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0F, 255.0F)));
    }
  }
}

Eigen::Isometry3d SyntheticWorld::T_first_current(double t_s) const {
  return scene_.T_world_camera(0.0).inverse() * scene_.T_world_camera(t_s);
}

PixelTruth SyntheticWorld::pixels(double t_s) const {
  Raster raster(camera_, 1);
  const auto patches =
      to_raster(scene_, t_s, scene_.T_world_camera(t_s).inverse(), raster.ray_of_sample(camera_));
  rasterise(patches, raster);
  PixelTruth truth;
  for (const Sample& sample : raster.samples) {
    const bool hit = sample.patch >= 0;
    truth.depth_m.push_back(hit ? 1.0F / sample.inverse_depth : 0.0F);
    truth.body_id.push_back(hit ? patches[static_cast<std::size_t>(sample.patch)].body_id : 0);
  }
  return truth;
}

std::vector<ObjectTruth> SyntheticWorld::objects(double t_s) const {
  const PixelTruth seen = pixels(t_s);
  const Eigen::Isometry3d T_world_camera = scene_.T_world_camera(t_s);
  std::vector<ObjectTruth> truths;
  for (const Body& body : scene_.bodies) {
    if (body.id == 0) continue;
    ObjectTruth truth;
    truth.id = body.id;
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    double area = 0.0;
    for (int v = 0; v < camera_.height_px; ++v) {
      for (int u = 0; u < camera_.width_px; ++u) {
        const auto i = static_cast<std::size_t>(v * camera_.width_px + u);
        if (seen.body_id[i] != body.id) continue;
        const double z = seen.depth_m[i];
        sum_m += Eigen::Vector3d((u - camera_.cx_px) / camera_.fx_px * z,
                                 (v - camera_.cy_px) / camera_.fy_px * z, z);
        area += 1.0;
        grow(truth, u, v);
      }
    }
    truth.box_centre_m = T_world_camera.inverse() * (body.T_world_body(t_s) * body.centre_m);
    truth.surface_centroid_m =
        truth.visible_px > 0 ? Eigen::Vector3d(sum_m / area) : truth.box_centre_m;
    const BodyMotion motion =
        motion_of(body.T_world_body, t_s, T_world_camera * truth.surface_centroid_m);
    truth.velocity_mps = T_world_camera.linear().transpose() * motion.velocity_mps;
    truth.angular_velocity_radps = T_world_camera.linear().transpose() * motion.angular_radps;
    truth.moving = truth.velocity_mps.norm() > 1e-3;
    const int alone = count_alone(scene_, body, t_s, T_world_camera.inverse(), camera_);
    truth.occluded_fraction = alone > 0 ? 1.0 - static_cast<double>(truth.visible_px) / alone : 0.0;
    truths.push_back(truth);
  }
  return truths;
}

}  // namespace egomod::test_support
