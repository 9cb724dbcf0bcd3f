#include "client/effects/debris.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace fracture::effects {
namespace {

/// How a material crumbles. The amounts were chosen by eye, compared with films of real breaks.
struct Crumbling {
  const char* name;
  glm::vec3 dust, crumb;  ///< colours, linear
  float puffs;            ///< per square metre of broken bond
  float density;          ///< opacity of a puff
  float crumbs;           ///< per square metre of broken bond
  float size;             ///< of the larger crumbs, metres
  float stretch;
  bool rays;   ///< whether a hit leaves cracks
  bool clear;  ///< leaves no mark, because a mark would be painted on the surface behind the clear object
};

const glm::vec3 kWhite(0.80f, 0.80f, 0.78f), kGrey(0.42f, 0.41f, 0.39f), kSand(0.52f, 0.46f, 0.37f);
const std::array<Crumbling, 8> kCrumbling = {{
    {"stone", {0.40f, 0.38f, 0.35f}, {0.34f, 0.32f, 0.30f}, 26, 0.20f, 300, 0.014f, 1.4f, true, false},
    {"glass", kWhite, {0.62f, 0.74f, 0.72f}, 6, 0.10f, 1400, 0.007f, 2.2f, true, true},
    {"wood", kSand, {0.36f, 0.24f, 0.13f}, 5, 0.14f, 500, 0.020f, 6.0f, false, false},
    {"concrete", kGrey, {0.38f, 0.37f, 0.35f}, 42, 0.22f, 420, 0.016f, 1.3f, true, false},
    {"brick", {0.45f, 0.25f, 0.17f}, {0.40f, 0.17f, 0.10f}, 38, 0.20f, 420, 0.014f, 1.4f, false, false},
    {"ceramic", kWhite, {0.70f, 0.69f, 0.66f}, 12, 0.18f, 700, 0.009f, 2.0f, true, false},
    {"metal", kGrey, {0.30f, 0.30f, 0.31f}, 0, 0, 20, 0.006f, 3.0f, false, false},
    {"ice", {0.80f, 0.86f, 0.90f}, {0.72f, 0.82f, 0.88f}, 22, 0.20f, 900, 0.012f, 1.6f, true, true},
}};

const Crumbling& crumbling(const std::string& material) {
  // Similar materials crumble alike.
  const std::string name = material == "terracotta"                           ? "brick"
                           : material == "sandstone" || material == "plaster" ? "stone"
                           : material == "cast_iron"                          ? "metal"
                           : material == "crystal"                            ? "glass"
                                                                              : material;
  const auto known = std::find_if(kCrumbling.begin(), kCrumbling.end(),
                                  [&](const Crumbling& entry) { return name == entry.name; });
  return known != kCrumbling.end() ? *known : kCrumbling.front();
}

constexpr float kGravity = 9.81f, kAirDrag = 2.2f;  // m/s²; 1/s, for dust
constexpr float kShrink = 1;                        // seconds, at the end of a crumb's life
constexpr double kScuffing = 2;                     // N·s: the smallest impulse that leaves a mark …
constexpr double kScuffSpeed = 1;                   // m/s: … and the smallest speed
constexpr std::size_t kMostOfOne = 60;              // crumbs from one bond or hit

template <class Item>
void keep_newest(std::vector<Item>& all, std::size_t most) {
  if (all.size() > most) all.erase(all.begin(), all.end() - static_cast<std::ptrdiff_t>(most));
}

/// Two directions perpendicular to `normal` and to each other.
std::pair<glm::vec3, glm::vec3> across(const glm::vec3& normal) {
  const glm::vec3 other = std::abs(normal.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
  const glm::vec3 x = glm::normalize(glm::cross(other, normal));
  return {x, glm::cross(normal, x)};
}

}  // namespace

float Puff::opacity() const {
  const float t = age / life, start = std::min(1.f, age / 0.06f);
  // The puff grows, but its amount of dust stays the same.
  return density * start * (1 - t) * (1 - t);
}

float Debris::random() {
  std::uint64_t z = seed_ * 0x9e3779b97f4a7c15ull + ++drawn_ * 0xd1342543de82ef95ull;  // SplitMix64
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return static_cast<float>((z ^ (z >> 31)) >> 40) / 16777216.f;
}

glm::vec3 Debris::random_direction() {
  const float y = 2 * random() - 1, angle = 6.2831853f * random(), r = std::sqrt(1 - y * y);
  return {r * std::cos(angle), y, r * std::sin(angle)};
}

std::size_t Debris::random_count(double mean) {
  return std::min(kMostOfOne, static_cast<std::size_t>(mean + static_cast<double>(random())));
}

void Debris::crack(const world::Crack& crack, const std::string& material) {
  const Crumbling& how = crumbling(material);
  const glm::vec3 middle(crack.point), moves(crack.velocity);
  const glm::vec3 normal = glm::length(crack.normal) > 0.5 ? glm::vec3(crack.normal) : random_direction();
  const std::pair<glm::vec3, glm::vec3> sides = across(normal);
  const glm::vec3 &x = sides.first, &y = sides.second;
  const float reach = 0.9f * std::sqrt(static_cast<float>(crack.area) / 3.14159265f);
  const auto place = [&](float& angle, float& r) {
    angle = 6.2831853f * random();
    r = std::sqrt(random());
    return middle + reach * r * (std::cos(angle) * x + std::sin(angle) * y);
  };
  for (std::size_t k = random_count(how.crumbs * crack.area); k > 0; --k) {
    Crumb crumb;
    float angle = 0, r = 0;
    crumb.position = place(angle, r);
    // Crumbs come out at the rim, along the crack.
    const glm::vec3 out = std::cos(angle) * x + std::sin(angle) * y;
    crumb.velocity = moves + (0.3f + 1.1f * r) * random() * out + 0.5f * random() * random_direction();
    crumb.axis = random_direction();
    crumb.turn = 6.2831853f * random();
    crumb.spin = 24 * (random() - 0.5f);
    const float u = random();
    crumb.size = how.size * (0.25f + 0.75f * u * u * u);  // most crumbs are small
    crumb.stretch = 1 + (how.stretch - 1) * (0.5f + 0.5f * random());
    crumb.color = how.crumb * (0.75f + 0.5f * random());
    crumb.life = 5 + 4 * random();
    crumbs_.push_back(crumb);
  }
  for (std::size_t k = random_count(how.puffs * crack.area); k > 0; --k) {
    Puff puff;
    float angle = 0, r = 0;
    puff.position = place(angle, r);
    puff.velocity = 0.5f * moves + 0.5f * random() * random_direction() + glm::vec3(0, 0.15f, 0);
    puff.radius = 0.06f + 0.08f * random();
    puff.growth = 0.35f + 0.35f * random();
    puff.turn = 6.2831853f * random();
    puff.shape = static_cast<std::uint32_t>(4 * random());
    puff.color = how.dust * (0.9f + 0.2f * random());
    puff.density = how.density * (0.6f + 0.4f * random());
    puff.life = 1.2f + 1.6f * random();
    puffs_.push_back(puff);
  }
}

void Debris::mark(const world::World& world, const world::Knock& knock, const world::Knock::Side& side,
                  const std::string& material, const std::string& other) {
  Mark mark;
  glm::dvec3 normal = knock.normal;
  if (side.kind == world::Knock::Side::Kind::kObject) {
    if (!side.fragment) return;  // it is about to break there, or the hit was weak
    const Crumbling& how = crumbling(material);
    if (how.clear) return;
    std::vector<world::FragmentState> states;
    world.fragment_states(side.object, states);
    if (*side.fragment >= states.size() || !states[*side.fragment].present) return;
    const world::Pose& pose = states[*side.fragment].asset_to_world;
    mark.on_object = true;
    mark.object = side.object;
    mark.fragment = *side.fragment;
    mark.position = glm::vec3(pose.local(knock.point));
    normal = glm::conjugate(pose.rotation) * normal;
    mark.color = 0.85f * how.dust;  // a scuff is powder
    mark.cracks = how.rays;
  } else {
    mark.position = glm::vec3(knock.point);
    const Crumbling& how = crumbling(other);
    mark.color = 0.8f * how.dust;
  }
  mark.normal = glm::normalize(glm::vec3(normal));
  mark.turn = 6.2831853f * random();
  mark.radius = std::clamp(0.035f * std::cbrt(static_cast<float>(knock.impulse)), 0.03f, 0.2f) *
                (0.8f + 0.4f * random());
  mark.opacity = std::clamp(0.12f * static_cast<float>(knock.approach), 0.15f, 0.6f);
  marks_.push_back(mark);
}

void Debris::knock(const world::World& world, const world::Knock& knock, const MaterialOf& material_of) {
  using Kind = world::Knock::Side::Kind;
  if (knock.impulse < kScuffing || knock.approach < kScuffSpeed) return;
  const auto name = [&](const world::Knock::Side& side) {
    return side.kind == Kind::kObject ? material_of(side.object)
           : side.kind == Kind::kBall ? std::string("metal")
                                      : std::string("concrete");
  };
  const std::string a = name(knock.a), b = name(knock.b);
  // Balls show no marks.
  if (knock.a.kind != Kind::kBall) mark(world, knock, knock.a, a, b);
  if (knock.b.kind != Kind::kBall) mark(world, knock, knock.b, b, a);
  for (const bool first : {true, false}) {
    const world::Knock::Side& side = first ? knock.a : knock.b;
    if (side.kind != Kind::kObject) continue;
    const Crumbling& how = crumbling(first ? a : b);
    const auto push = static_cast<float>(std::sqrt(knock.impulse));
    for (std::size_t k = std::min<std::size_t>(3, random_count(0.004 * how.puffs * push)); k > 0; --k) {
      Puff puff;
      puff.position = glm::vec3(knock.point) + 0.05f * random_direction();
      const glm::vec3 way = random_direction();
      puff.velocity = 0.5f * glm::vec3(way.x, 0.3f * std::abs(way.y), way.z);
      puff.radius = 0.05f + 0.05f * random();
      puff.growth = 0.3f + 0.3f * random();
      puff.turn = 6.2831853f * random();
      puff.shape = static_cast<std::uint32_t>(4 * random());
      puff.color = how.dust;
      puff.density = 0.7f * how.density;
      puff.life = 0.8f + random();
      puffs_.push_back(puff);
    }
  }
}

void Debris::move(float seconds) {
  for (Crumb& crumb : crumbs_) {
    crumb.age += seconds;
    if (crumb.velocity == glm::vec3(0)) continue;
    crumb.velocity.y -= kGravity * seconds;
    crumb.position += seconds * crumb.velocity;
    crumb.turn += seconds * crumb.spin;
    const float lies = 0.4f * crumb.size / crumb.stretch;
    if (crumb.position.y > lies || crumb.velocity.y > 0) continue;
    crumb.position.y = lies;
    crumb.velocity = {0.55f * crumb.velocity.x, -0.3f * crumb.velocity.y, 0.55f * crumb.velocity.z};
    crumb.spin *= 0.5f;
    constexpr float kRests = 0.12f;  // m/s: slower crumbs come to rest
    if (glm::dot(crumb.velocity, crumb.velocity) < kRests * kRests) crumb.velocity = glm::vec3(0);
  }
  const float kept = std::exp(-kAirDrag * seconds);
  for (Puff& puff : puffs_) {
    puff.age += seconds;
    puff.velocity *= kept;
    puff.growth *= std::exp(-0.9f * seconds);
    puff.radius += seconds * puff.growth;
    puff.position += seconds * puff.velocity;
    puff.position.y = std::max(puff.position.y, 0.3f * puff.radius);
  }
  std::erase_if(crumbs_, [](const Crumb& crumb) { return crumb.age >= crumb.life + kShrink; });
  std::erase_if(puffs_, [](const Puff& puff) { return puff.age >= puff.life; });
}

void Debris::follow(const world::World& world, const world::Witnessed& witnessed,
                    const MaterialOf& material_of) {
  for (const world::Crack& crack : witnessed.cracks) this->crack(crack, material_of(crack.object));
  for (const world::Knock& knock : witnessed.knocks) this->knock(world, knock, material_of);
  keep_newest(crumbs_, kMostCrumbs);
  keep_newest(puffs_, kMostPuffs);
  keep_newest(marks_, kMostMarks);
  const auto length = static_cast<float>(world.settings().step);
  for (; step_ < world.steps(); ++step_) move(length);
}

}  // namespace fracture::effects
