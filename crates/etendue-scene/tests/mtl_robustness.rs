//! No library panics, whatever is in it, and every material that comes out is one that can be rendered.

use etendue_scene::{SourceMap, mesh_file::KeyStatus, mtl};
use proptest::{prelude::*, test_runner::RngSeed};

const KEYS: &str = "Ka Kd Ks Ke Tf Ns Ni d Tr illum Pr Pm Ps Pc Pcr aniso anisor Td Ts Nst n texture scatter BRDF map_Ka \
                    map_Kd map_Ks map_Ke map_Ns map_d map_Pr map_Pm map_Ps map_Pc map_Pcr bump map_Bump norm disp decal \
                    refl sharpness map_aat newmtl kd what";

const WORDS: &str = "0 1 0.5 -1 7 1000 1e30 1e-40 nan inf 1e999 1,5 -s -o -t -bm -mm -clamp -imfchan -blendu -blendv \
                     -boost -texres -type -cc -halo on off r g b m l z sphere Kd Ks Td Ts a.png my b_n.png #c \"d e\" \
                     \\ folder\\f.jpg AreaLightSource GlobalScatter spectral xyz é";

fn any_of(words: &'static str) -> impl Strategy<Value = &'static str> {
    prop::sample::select(words.split_ascii_whitespace().collect::<Vec<_>>())
}

fn text() -> impl Strategy<Value = String> {
    let end = prop::sample::select(vec!["\n", "\r\n", " \\\n", "\r"]);
    let line = (any_of(KEYS), prop::collection::vec(any_of(WORDS), 0..9), end)
        .prop_map(|(key, words, end)| format!("{key} {}{end}", words.join(" ")));
    prop::collection::vec(line, 0..40).prop_map(|lines| format!("newmtl a\n{}", lines.concat()))
}

fn check(bytes: &[u8]) {
    let mut sources = SourceMap::new();
    let file = sources.insert("m.mtl", bytes.to_vec()).unwrap();
    let library = mtl::read(bytes, file);
    for named in &library.materials {
        assert_eq!(named.material.validate(), Ok(()), "{named:?}");
        assert!(named.origin.as_ref().unwrap().span().unwrap().end <= bytes.len());
    }
    for used in &library.keys {
        let span = used.first.span().unwrap();
        assert!(used.count > 0 && span.end <= bytes.len(), "{used:?}");
        assert!(used.status == KeyStatus::Used || !used.key.is_empty(), "{used:?}");
        sources.position(span);
    }
    for finding in &library.findings {
        finding.one_line(&sources);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, rng_seed: RngSeed::Fixed(7), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_statements(text in text()) {
        check(text.as_bytes());
    }

    #[test]
    fn any_change(text in text(), changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let mut bytes = text.into_bytes();
        for (index, byte) in changes {
            let at = index.index(bytes.len());
            match byte % 3 {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ => bytes.truncate(at.max(1)),
            }
        }
        check(&bytes);
    }
}
