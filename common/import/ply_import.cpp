#include "common/import/ply_import.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "common/import/file_textures.hpp"
#include "common/import/ply_data.hpp"
#include "common/import/ply_header.hpp"
#include "common/import/polygon_file.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_encoding.hpp"

namespace fracture {
namespace {

/// Values of a vertex that are read, as positions in a row.
enum PlySlot : std::size_t { kX, kY, kZ, kNx, kNy, kNz, kRed, kGreen, kBlue, kAlpha, kU, kV, kPlySlots };

struct PlySlotName {
  std::string_view name;
  PlySlot slot;
};
constexpr PlySlotName kPlySlotNames[] = {
    {"x", kX},
    {"y", kY},
    {"z", kZ},
    {"nx", kNx},
    {"ny", kNy},
    {"nz", kNz},
    {"red", kRed},
    {"green", kGreen},
    {"blue", kBlue},
    {"alpha", kAlpha},
    {"r", kRed},
    {"g", kGreen},
    {"b", kBlue},
    {"a", kAlpha},
    {"diffuse_red", kRed},
    {"diffuse_green", kGreen},
    {"diffuse_blue", kBlue},
    {"diffuse_alpha", kAlpha},
    {"u", kU},
    {"v", kV},
    {"s", kU},
    {"t", kV},
    {"tx", kU},
    {"ty", kV},
    {"texture_u", kU},
    {"texture_v", kV},
};

/// A colour's value in [0, 1]. Types of 32 bits hold bytes, too.
double color_value(double value, PlyType type) {
  switch (type) {
    case PlyType::kFloat:
    case PlyType::kDouble:
      return value;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return static_cast<double>(static_cast<float>(value) / 65535.0f);
    case PlyType::kInt8:  // a byte with the wrong type
      return static_cast<double>(static_cast<float>(value < 0 ? value + 256 : value) / 255.0f);
    default:
      return static_cast<double>(static_cast<float>(value) / 255.0f);
  }
}

template <class Data>
class PlyReader {
 public:
  PlyReader(const PlyHeader& header, Data data, const ImportLimits& limits, PolygonFile& file)
      : header_(header), data_(data), limits_(limits), file_(file) {}

  void read() {
    for (const PlyElement& element : header_.elements)
      if (element.name == "vertex" && !element.properties.empty()) vertices_ = element.count;
    for (const PlyElement& element : header_.elements) {
      if (element.properties.empty() || element.count == 0) continue;
      if (element.name == "vertex")
        read_vertices(element);
      else if (element.name == "face")
        read_faces(element);
      else if (element.name == "tristrips")
        read_strips(element);
      else
        skip_element(element);
    }
    if (has_corner_uvs_) {
      file_.uvs.clear();
      file_.corner_uvs.resize(file_.corners.size());
    } else {
      file_.corner_uvs.clear();  // all lists are empty
    }
    if (!file_.face_material.empty()) file_.face_material.resize(file_.face_end.size(), 0);
    file_.end_part({});
  }

 private:
  void drop_property(const PlyElement& element, const PlyProperty& property, const char* reason) {
    file_.dropped.push_back({element.name + " property", name_as_utf8(property.name), reason});
  }

  void skip_property(const PlyProperty& property) {
    data_.skip(property.type, property.length ? data_.length(*property.length, property.type) : 1);
  }

  void skip_element(const PlyElement& element) {
    file_.dropped.push_back(
        {"element", name_as_utf8(element.name), "only vertices, faces and triangle strips are read"});
    for (std::uint64_t k = 0; k < element.count; ++k) {
      data_.begin();
      for (const PlyProperty& property : element.properties) skip_property(property);
      data_.end();
    }
  }

  void read_vertices(const PlyElement& element) {
    std::vector<std::size_t> slots(element.properties.size(), kPlySlots);
    std::array<bool, kPlySlots> has{};
    for (std::size_t p = 0; p < slots.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      for (const PlySlotName& known : kPlySlotNames)
        if (!property.length && property.name == known.name && !has[known.slot]) slots[p] = known.slot;
      if (slots[p] == kPlySlots)
        drop_property(element, property,
                      "only position, normal, colour and texture coordinates of a vertex are read");
      else
        has[slots[p]] = true;
    }
    if (!has[kX] || !has[kY] || !has[kZ])
      refuse(ErrorCode::kMalformedMesh,
             "The PLY's element \"vertex\" needs the properties x, y and z. Export the file again.");
    const bool normals = has[kNx] && has[kNy] && has[kNz], uvs = has[kU] && has[kV];
    const bool colors = has[kRed] || has[kGreen] || has[kBlue];
    limit_vertices(element.count, 12u + (normals ? 12u : 0u) + (colors ? 16u : 0u) + (uvs ? 8u : 0u),
                   limits_);
    if (normals) file_.normals.reserve(element.count);
    if (colors) file_.colors.reserve(element.count);
    if (uvs) file_.uvs.reserve(element.count);
    std::array<double, kPlySlots> row{};
    row[kAlpha] = 1;
    const auto value = [&row](std::size_t slot) { return static_cast<float>(row[slot]); };
    for (std::uint64_t k = 0; k < element.count; ++k) {
      const std::size_t at = data_.begin();
      for (std::size_t p = 0; p < slots.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        const std::size_t slot = slots[p];
        if (slot == kPlySlots) {
          skip_property(property);
          continue;
        }
        row[slot] = data_.number(property.type);
        if (slot >= kRed && slot <= kAlpha) row[slot] = color_value(row[slot], property.type);
      }
      data_.end();
      file_.add_position({row[kX], row[kY], row[kZ]}, at);
      if (normals) file_.normals.push_back({value(kNx), value(kNy), value(kNz)});
      if (colors) file_.colors.push_back({value(kRed), value(kGreen), value(kBlue), value(kAlpha)});
      if (uvs) file_.uvs.push_back({value(kU), value(kV)});
    }
  }

  /// Which properties of a face are read.
  struct FaceProperties {
    std::size_t indices, uvs, texture;
  };
  FaceProperties find_face_properties(const PlyElement& element) {
    const std::size_t none = element.properties.size();
    FaceProperties found{none, none, none};
    bool colored = false;
    for (std::size_t p = 0; p < none; ++p) {
      const PlyProperty& property = element.properties[p];
      const std::string_view name = property.name;
      const bool list = property.length.has_value();
      if (list && found.indices == none && (name == "vertex_indices" || name == "vertex_index"))
        found.indices = p;
      else if (list && found.uvs == none && name == "texcoord")
        found.uvs = p;
      else if (!list && found.texture == none && name == "texnumber")
        found.texture = p;
      else if (!list && (name == "red" || name == "green" || name == "blue" || name == "alpha"))
        colored = true;
      else
        drop_property(element, property, "only corners and texture coordinates of a face are read");
    }
    if (colored) file_.dropped.push_back({"face colours", {}, "only vertex colours are read"});
    if (found.indices == none)
      refuse(ErrorCode::kMalformedMesh,
             "The PLY's element \"face\" has no list vertex_indices or vertex_index, so its corners are "
             "unknown. Export the file again.");
    return found;
  }

  void read_faces(const PlyElement& element) {
    limit_faces(element.count, limits_);
    const FaceProperties which = find_face_properties(element);
    texture_of_corners_ = which.uvs != element.properties.size();
    std::vector<float> uvs;
    file_.face_end.reserve(element.count);
    for (std::uint64_t k = 0; k < element.count; ++k) {
      const std::size_t at = data_.begin(), begin = file_.corners.size();
      double texture = 0;
      uvs.clear();
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        if (p == which.indices) {
          const std::uint64_t count = data_.length(*property.length, property.type);
          file_.limit_corners(count, limits_);
          for (std::uint64_t c = 0; c < count; ++c)
            file_.add_corner(data_.number(property.type), vertices_, at);
        } else if (p == which.uvs) {
          const std::uint64_t count = data_.length(*property.length, property.type);
          file_.limit_corners(count / 2, limits_);
          for (std::uint64_t c = 0; c < count; ++c)
            uvs.push_back(static_cast<float>(data_.number(property.type)));
        } else if (p == which.texture) {
          texture = data_.number(property.type);
        } else {
          skip_property(property);
        }
      }
      data_.end();
      const std::size_t corners = file_.corners.size() - begin, faces = file_.face_end.size();
      file_.end_face(limits_);
      if (file_.face_end.size() == faces) continue;  // a point or a line
      if (texture_of_corners_) add_corner_uvs(uvs, corners);
      if (which.texture != element.properties.size()) add_texture_number(texture);
    }
  }

  void add_corner_uvs(const std::vector<float>& uvs, std::size_t corners) {
    const bool complete = uvs.size() == 2 * corners;
    has_corner_uvs_ |= complete;
    file_.corner_uvs.resize(file_.corners.size() - corners);  // strips before the faces have none
    for (std::size_t c = 0; c < corners; ++c)
      file_.corner_uvs.push_back(complete ? Vec2f{uvs[2 * c], uvs[2 * c + 1]} : Vec2f{});
    if (complete || uvs.empty() || warned_) return;
    warned_ = true;
    file_.remarks.warn(
        "Some faces of the PLY have more or fewer texture coordinates than corners, so these coordinates were "
        "left out. The texture is wrong there. Export the file again.");
  }

  void add_texture_number(double number) {
    const bool exists = number >= 0 && number < static_cast<double>(header_.textures.size());
    file_.face_material.resize(file_.face_end.size() - 1, 0);
    file_.face_material.push_back(exists ? static_cast<std::uint32_t>(number) : 0);
  }

  void read_strips(const PlyElement& element) {
    std::size_t list = 0;
    while (list < element.properties.size() && !element.properties[list].length) ++list;
    for (std::uint64_t k = 0; k < element.count; ++k) {
      const std::size_t at = data_.begin();
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        if (p == list)
          read_strip(element.properties[p], at);
        else
          skip_property(element.properties[p]);
      }
      data_.end();
    }
  }

  /// Every second triangle of a strip is turned over.
  void read_strip(const PlyProperty& property, std::size_t at) {
    const std::uint64_t count = data_.length(*property.length, property.type);
    std::array<double, 2> last{};  // the two vertices before this one
    std::size_t seen = 0;
    bool turned = false;
    for (std::uint64_t c = 0; c < count; ++c) {
      const double vertex = data_.number(property.type);
      if (vertex == -1 || vertex == 4294967295.0) {
        seen = 0;
        turned = false;
        continue;
      }
      if (seen >= 2) {
        for (const double corner : {last[turned ? 1 : 0], last[turned ? 0 : 1], vertex})
          file_.add_corner(corner, vertices_, at);
        file_.end_face(limits_);
        turned = !turned;
      }
      last = {last[1], vertex};
      ++seen;
    }
  }

  const PlyHeader& header_;
  Data data_;
  ImportLimits limits_;
  PolygonFile& file_;
  std::uint64_t vertices_ = 0;
  bool texture_of_corners_ = false, has_corner_uvs_ = false, warned_ = false;
};

void add_ply_materials(const PlyHeader& header, std::span<const ImportFile> files, PolygonFile& file) {
  FileTextures textures(files, file.library, file.remarks, file.dropped);
  for (std::size_t k = 0; k < std::max<std::size_t>(1, header.textures.size()); ++k) {
    nlohmann::json material = plain_material({1, 1, 1});
    if (k < header.textures.size()) {
      const std::uint32_t texture = textures.texture(header.textures[k]);
      if (texture != kNoIndex) material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", texture}};
    }
    file.library.materials.push_back(std::move(material));
  }
  file.material = 0;
}

}  // namespace

Expected<Mesh> import_ply(std::span<const std::byte> bytes, const ImportLimits& limits,
                          std::span<const ImportFile> files) {
  try {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const PlyHeader header = read_ply_header(text);
    const bool faces = std::any_of(header.elements.begin(), header.elements.end(), [](const PlyElement& e) {
      return (e.name == "face" || e.name == "tristrips") && e.count > 0;
    });
    if (!faces) refuse(ErrorCode::kEmptyMesh, "The PLY declares no faces: a point cloud encloses no volume.");
    PolygonFile file;
    file.places = {text, header.encoding == PlyEncoding::kText};
    if (file.places.text)
      PlyReader<PlyTextData>(header, PlyTextData(text, header), limits, file).read();
    else
      PlyReader<PlyBinaryData>(header, PlyBinaryData(bytes, header), limits, file).read();
    add_ply_materials(header, files, file);
    return finish_polygon_file(std::move(file), limits);
  } catch (const Refused& refused) {
    return tl::unexpected<Error>(refused.error);
  }
}

}  // namespace fracture
