#include "remaps/codec/base_code.h"

#include <algorithm>
#include <bit>
#include <unordered_map>

#include "remaps/base/errors.h"
#include "remaps/codec/binary_coder.h"
#include "remaps/codec/bit_predictor.h"

namespace remaps::codec {
namespace {

using GridPoint = std::array<std::int32_t, 3>;

std::uint64_t edge_key(std::uint32_t from, std::uint32_t to) {
  return std::uint64_t{from} << 32 | to;
}

/// A mesh that grows face by face; faces that have an edge in common are joined as they come.
class GrowingMesh {
 public:
  std::uint32_t faces() const { return static_cast<std::uint32_t>(face_.size()); }
  std::uint32_t vertices() const { return static_cast<std::uint32_t>(degree_.size()); }
  const std::vector<Face>& face() const { return face_; }

  std::uint32_t from(Side s) const { return face_[s.face()][s.corner()]; }
  std::uint32_t to(Side s) const { return face_[s.face()][Side::next_corner(s.corner())]; }
  std::uint32_t opposite(Side s) const {
    return face_[s.face()][Side::previous_corner(s.corner())];
  }
  Side twin(Side s) const { return twin_[s.face()][s.corner()]; }
  /// Number of faces at a vertex.
  std::uint32_t degree(std::uint32_t vertex) const { return degree_[vertex]; }

  /// The vertex before the start of an open side along the border of what is known, and the one
  /// after its end. Constant time: a hostile base may have a vertex of any valence.
  std::uint32_t before(Side s) const { return from(border_[s.face()][s.corner()].before); }
  std::uint32_t after(Side s) const { return to(border_[s.face()][s.corner()].after); }

  /// Whether a face may be added: three different vertices, no side that is there already.
  bool accepts(const Face& f) const {
    if (f[0] == f[1] || f[1] == f[2] || f[2] == f[0]) return false;
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (side_of_.contains(edge_key(f[k], f[Side::next_corner(k)]))) return false;
    }
    return true;
  }
  /// Corners may be as many as there are vertices, and then are new ones.
  void add(const Face& f) {
    const std::uint32_t number = faces();
    face_.push_back(f);
    twin_.emplace_back();
    border_.emplace_back();
    for (std::uint32_t k = 0; k < 3; ++k) {
      const Side s(number, k);
      border_[number][k] = {s.previous(), s.next()};
    }
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (f[k] >= degree_.size()) degree_.resize(f[k] + std::size_t{1}, 0);
      ++degree_[f[k]];
      const std::uint32_t a = f[k], b = f[Side::next_corner(k)];
      side_of_.emplace(edge_key(a, b), Side(number, k));
      const auto other = side_of_.find(edge_key(b, a));
      if (other != side_of_.end()) join(Side(number, k), other->second);
    }
  }

 private:
  /// The open sides along the border before and after an open one.
  struct Neighbours {
    Side before, after;
  };

  /// Two open sides become an edge: what was beside them along the border is joined.
  void join(Side a, Side b) {
    twin_[a.face()][a.corner()] = b;
    twin_[b.face()][b.corner()] = a;
    const Neighbours at_a = border_[a.face()][a.corner()], at_b = border_[b.face()][b.corner()];
    if (at_a.before != b) connect(at_a.before, at_b.after);
    if (at_b.before != a) connect(at_b.before, at_a.after);
  }
  void connect(Side first, Side second) {
    border_[first.face()][first.corner()].after = second;
    border_[second.face()][second.corner()].before = first;
  }

  std::vector<Face> face_;
  std::vector<std::array<Side, 3>> twin_;
  std::vector<std::array<Neighbours, 3>> border_;
  std::vector<std::uint32_t> degree_;
  std::unordered_map<std::uint64_t, Side> side_of_;
};

/// Walks over a mesh across its edges. What lies across an edge is told by `Source`, which has
/// `bool seed(Face&)`, true if there is one more component, whose first face it gives; and
/// `bool across(Side, std::uint32_t& third)`, false if there is nothing.
/// @param most_faces  ends the walk
template <class Source>
void grow(GrowingMesh& mesh, Source& source, std::uint32_t most_faces) {
  std::vector<Side> gates;
  const auto push = [&](std::uint32_t face, std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t k = first + count; k-- > first;) gates.push_back(Side(face, k % 3));
  };
  while (mesh.faces() < most_faces) {
    if (gates.empty()) {
      Face face;
      if (!source.seed(face)) return;
      mesh.add(face);
      push(mesh.faces() - 1, 0, 3);
      continue;
    }
    const Side gate = gates.back();
    gates.pop_back();
    if (!mesh.twin(gate).none()) continue;
    std::uint32_t third = 0;
    if (!source.across(gate, third)) continue;
    mesh.add({mesh.to(gate), mesh.from(gate), third});
    push(mesh.faces() - 1, 1, 2);
  }
}

/// Tells a walk what a given mesh has, and remembers the numbers that things get.
class GivenMesh {
 public:
  GivenMesh(std::uint32_t vertices, std::span<const Face> faces, const GrowingMesh& grown)
      : faces_(faces), grown_(grown) {
    order_.vertex.assign(vertices, kNoIndex);
    order_.face.assign(faces.size(), kNoIndex);
    order_.rotation.assign(faces.size(), 0);
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        const auto [a, b] = std::pair(faces[f][k], faces[f][Side::next_corner(k)]);
        if (a >= vertices) throw GeometryError("a base face has a corner that is not there");
        if (!side_of_.emplace(edge_key(a, b), Side(f, k)).second) {
          throw GeometryError("two base faces have the same side");
        }
      }
    }
  }

  bool seed(Face& face) {
    while (next_ < faces_.size() && order_.face[next_] != kNoIndex) ++next_;
    if (next_ == faces_.size()) return false;
    face = place(static_cast<std::uint32_t>(next_), 0);
    return true;
  }
  bool across(Side gate, std::uint32_t& third) {
    const auto there = side_of_.find(edge_key(given(grown_.to(gate)), given(grown_.from(gate))));
    if (there == side_of_.end()) return false;
    const Side side = there->second;
    third = place(side.face(), (3 - side.corner()) % 3)[2];
    return true;
  }

  BaseOrder release() && { return std::move(order_); }

 private:
  std::uint32_t given(std::uint32_t vertex) const { return given_[vertex]; }
  Face place(std::uint32_t number, std::uint32_t rotation) {
    order_.face[number] = placed_++;
    order_.rotation[number] = static_cast<std::uint8_t>(rotation);
    Face result;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t v = faces_[number][(k + 3 - rotation) % 3];
      if (order_.vertex[v] == kNoIndex) {
        order_.vertex[v] = static_cast<std::uint32_t>(given_.size());
        given_.push_back(v);
      }
      result[k] = order_.vertex[v];
    }
    return result;
  }

  std::span<const Face> faces_;
  const GrowingMesh& grown_;
  std::unordered_map<std::uint64_t, Side> side_of_;
  BaseOrder order_;
  std::vector<std::uint32_t> given_;  // (vertices so far) their numbers in the given mesh
  std::size_t next_ = 0;
  std::uint32_t placed_ = 0;
};

/// Codes integers that are mostly small: their length in bits one by one, then the bits below the
/// highest.
class DifferenceCoder {
 public:
  DifferenceCoder() : length_({kLengths}, 1), bit_({kLengths * 4}, 1) {}

  template <class Coder>
  std::int32_t code(Coder& coder, std::int32_t value) {
    const bool negative = value < 0;
    const std::uint32_t size =
        negative ? 0 - static_cast<std::uint32_t>(value) : static_cast<std::uint32_t>(value);
    const auto wanted = static_cast<unsigned>(std::bit_width(size));
    unsigned length = 0;
    while (length < kLengths - 1 &&
           length_.code(coder, length < wanted, {std::size_t{length}}, 0)) {
      ++length;
    }
    if (length == 0) return 0;
    std::uint32_t decoded = 1;
    for (unsigned i = length - 1; i-- > 0;) {
      const bool bit = (size >> i & 1) != 0;
      const std::size_t depth = std::min<std::size_t>(length - 2 - i, 3);
      decoded = decoded << 1 | (bit_.code(coder, bit, {length * 4 + depth}, 0) ? 1u : 0u);
    }
    const auto magnitude = static_cast<std::int32_t>(decoded);
    return coder.code(negative, 1 << 15) ? -magnitude : magnitude;
  }

 private:
  static constexpr std::size_t kLengths = 32;

  MixedBit<1> length_, bit_;
};

/// Both directions of the code. The encoder walks over the base that it is given, the decoder over
/// the one that it makes.
template <class Coder>
class BaseCoder {
 public:
  BaseCoder(Coder& coder, const GridBase* given, std::uint32_t vertices, std::uint32_t faces)
      : coder_(coder), given_(given), vertices_(vertices), faces_(faces) {}

  GridBase run() {
    grow(mesh_, *this, faces_);
    if (mesh_.faces() != faces_ || mesh_.vertices() != vertices_) {
      throw GeometryError("the code of the base mesh does not give its vertices and faces");
    }
    return {std::move(position_), mesh_.face()};
  }

  bool seed(Face& face) {
    // The encoder's base is in order, so that the next face is the seed.
    for (std::uint32_t& v : face) {
      const bool first = position_.empty();
      v = add_vertex(first ? GridPoint{} : position_.back());
    }
    return true;
  }

  bool across(Side gate, std::uint32_t& third) {
    const std::uint32_t a = mesh_.from(gate), b = mesh_.to(gate);
    const std::size_t at_a = std::min(mesh_.degree(a), 11u), at_b = std::min(mesh_.degree(b), 11u);
    // In the encoder the face across is the next one, if it is there at all.
    bool there = true, is_new = false, is_before = false, is_after = false;
    const std::uint32_t before = mesh_.before(gate), after = mesh_.after(gate);
    if (given_ != nullptr) {
      const Face& next = given_->face[mesh_.faces()];
      there = next[0] == b && next[1] == a;
      third = next[2];
      is_new = there && third == mesh_.vertices();
      is_before = there && third == before;
      is_after = there && third == after;
    }
    if (!exists_.code(coder_, there, {at_a * 12 + at_b}, 0)) return false;
    const std::size_t close = before == after ? 1 : 0;
    const std::size_t context = (at_a * 12 + at_b) * 2 + close;
    if (kind_.code(coder_, is_new, {context, std::min<std::size_t>(at_a + at_b, 23)}, 0)) {
      const GridPoint &p = position_[a], &q = position_[b], &c = position_[mesh_.opposite(gate)];
      GridPoint guess;
      for (std::size_t k = 0; k < 3; ++k) {
        guess[k] = (3 * (p[k] + q[k]) - 2 * c[k]) / 4;
      }
      third = add_vertex(guess);
      return true;
    }
    if (before_.code(coder_, is_before, {context}, 0)) {
      third = before;
    } else if (after_.code(coder_, is_after, {context}, 0)) {
      third = after;
    } else {
      third = code_number(third);
    }
    if (!mesh_.accepts({b, a, third})) {
      throw GeometryError("the code of the base mesh gives two faces on one side of an edge");
    }
    return true;
  }

 private:
  std::uint32_t add_vertex(const GridPoint& guess) {
    const std::size_t number = position_.size();
    if (number >= vertices_) {
      throw GeometryError("the code of the base mesh gives more vertices than it has");
    }
    GridPoint p;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t step = given_ != nullptr ? given_->position[number][k] - guess[k] : 0;
      // Unsigned: a hostile code may overflow.
      p[k] = static_cast<std::int32_t>(static_cast<std::uint32_t>(guess[k]) +
                                       static_cast<std::uint32_t>(difference_.code(coder_, step)));
      // Before more is made of nothing.
      if (coder_.ended()) throw GeometryError("the code of the base mesh ends too early");
      if (p[k] < -kFarthest || p[k] > kFarthest) {
        throw GeometryError("the code of the base mesh has a vertex outside its grid");
      }
    }
    position_.push_back(p);
    return static_cast<std::uint32_t>(number);
  }

  std::uint32_t code_number(std::uint32_t vertex) {
    std::uint32_t number = 0;
    for (auto i = static_cast<unsigned>(std::bit_width(mesh_.vertices())); i-- > 0;) {
      number |= (coder_.code((vertex >> i & 1) != 0, 1 << 15) ? 1u : 0u) << i;
    }
    if (number >= mesh_.vertices()) {
      throw GeometryError("the code of the base mesh names a vertex that is not there yet");
    }
    return number;
  }

  static constexpr std::int32_t kFarthest = 1 << 27;

  Coder& coder_;
  const GridBase* given_;
  std::uint32_t vertices_, faces_;
  GrowingMesh mesh_;
  std::vector<GridPoint> position_;
  MixedBit<1> exists_{{144}, 1};
  MixedBit<2> kind_{{288, 24}, 1};
  MixedBit<1> before_{{288}, 1};
  MixedBit<1> after_{{288}, 1};
  DifferenceCoder difference_;
};

}  // namespace

BaseOrder order_base(std::uint32_t vertices, std::span<const Face> faces) {
  GrowingMesh mesh;
  GivenMesh given(vertices, faces, mesh);
  grow(mesh, given, static_cast<std::uint32_t>(faces.size()));
  return std::move(given).release();
}

store::Bytes encode_base(const GridBase& base) {
  store::Bytes code;
  BinaryEncoder encoder(code);
  BaseCoder<BinaryEncoder>(encoder, &base, static_cast<std::uint32_t>(base.position.size()),
                           static_cast<std::uint32_t>(base.face.size()))
      .run();
  encoder.finish();
  return code;
}

GridBase decode_base(store::ByteSpan code, std::uint32_t vertices, std::uint32_t faces) {
  BinaryDecoder decoder(code);
  GridBase base = BaseCoder<BinaryDecoder>(decoder, nullptr, vertices, faces).run();
  if (decoder.ended()) throw GeometryError("the code of the base mesh ends too early");
  return base;
}

}  // namespace remaps::codec
