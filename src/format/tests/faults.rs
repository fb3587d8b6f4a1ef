//! What is refused, where, and in which words.

use super::parsed;

#[track_caller]
fn assert_faults(cases: &[(&str, &str)]) {
    for (text, expected) in cases {
        match parsed(text, &[]) {
            Ok(_) => panic!("{text:?} was accepted"),
            Err(e) => assert_eq!(e.to_string(), format!("dir/s.toml:{expected}"), "{text:?}"),
        }
    }
}

#[test]
fn unknown_keys_and_values_are_refused_with_a_suggestion() {
    let cases = [
        ("[film]\nwidht = 3", "2:1: unknown key `widht` in [film]: did you mean `width`?"),
        ("\n[fil]\nwidth = 3", "2:2: unknown key `fil` in the scene file: did you mean `film`?"),
        (
            "[guiding]\nmethod = \"none\"\nresoluton = 8",
            "3:1: unknown key `resoluton` in [guiding]: did you mean `resolution`?",
        ),
        ("[render]\n  sed = 1", "2:3: unknown key `sed` in [render]: did you mean `seed`?"),
        ("[film]\ntone = 'acse'", "2:8: unknown tone `acse` in [film]: did you mean `aces`?"),
        ("[film]\nfilter = 'gausian'", "2:10: unknown filter `gausian` in [film]: did you mean `gaussian`?"),
        (
            "[integrator]\nroulette = 'albedo'",
            "2:12: unknown roulette `albedo` in [integrator]: known are `guided`, `throughput` and `none`",
        ),
        ("[material.A]\ntype = 'difuse'", "2:8: unknown type `difuse` in [material.A]: did you mean `diffuse`?"),
        (
            "[[mesh]]\npath = 'a.obj'\n[[mesh]]\npath = 'b.obj'\nmaterail = 'A'",
            "5:1: unknown key `materail` in [[mesh]]: did you mean `material`?",
        ),
        (
            "[[mesh]]\npath = 'a.obj'\nrotate = { axis = [0, 1, 0], angle = 3, axes = 1 }",
            "3:41: unknown key `axes` in `rotate` of [[mesh]]: did you mean `axis`?",
        ),
        (
            "[material.A]\ntype = 'diffuse'\nreflectance = { texture = 'a.png', scal = 2 }",
            "3:36: unknown key `scal` in `reflectance` of [material.A]: did you mean `scale`?",
        ),
        (
            "[material.A]\ntype = 'diffuse'\nopacity = { texture = 'a.png', tint = 1 }",
            "3:32: unknown key `tint` in `opacity` of [material.A]: known are `texture`, `scale`, \
             `offset`, `clamp`, `nearest` and `channel`",
        ),
        (
            "# é\n[film]\n\"é\" = 0 ",
            "3:1: unknown key `é` in [film]: known are `width`, `height`, `filter`, `crop`, `exposure` and `tone`",
        ),
    ];
    assert_faults(&cases);
}

#[test]
fn unknown_choices_of_the_guide_are_refused() {
    let cases = [
        ("[guiding]\nmethod = 'grids'", "2:10: unknown method `grids` in [guiding]: did you mean `grid`?"),
        ("[guiding]\ntable = 'tee'", "2:9: unknown table `tee` in [guiding]: did you mean `tree`?"),
        ("[guiding]\nrule = 'q-learnin'", "2:8: unknown rule `q-learnin` in [guiding]: did you mean `q-learning`?"),
        ("[guiding]\nrate = 'vanish'", "2:8: unknown rate `vanish` in [guiding]: did you mean `vanishing`?"),
        ("[guiding]\nsampling = 'qcos'", "2:12: unknown sampling `qcos` in [guiding]: did you mean `q-cos`?"),
        ("[guiding]\nupdates = 'on-line'", "2:11: unknown updates `on-line` in [guiding]: did you mean `online`?"),
    ];
    assert_faults(&cases);
}

#[test]
fn keys_of_another_type_are_refused() {
    let cases = [
        (
            "[material.A]\ntype = 'diffuse'\nalpha = 0.1",
            "3:1: `alpha` is not a key of type `diffuse`, but of `conductor`, `dielectric` and `plastic`",
        ),
        (
            "[material.A]\nalpha = 0.1\ntype = 'mirror'",
            "2:1: `alpha` is not a key of type `mirror`, but of `conductor`, `dielectric` and `plastic`",
        ),
        (
            "[material.A]\ntype = 'dielectric'\ntwo_sided = true",
            "3:1: `two_sided` is not a key of type `dielectric`, but of `diffuse`, `mirror`, \
             `conductor`, `plastic` and `principled`",
        ),
    ];
    assert_faults(&cases);
}

#[test]
fn wrong_types_are_refused() {
    let cases = [
        ("film = 3", "1:8: [film] must be a table, found an integer"),
        ("[film]\nwidth = 3.5", "2:9: `width` must be an integer, found a number with a fraction"),
        ("[film]\nwidth = 2020-01-01", "2:9: `width` must be an integer, found a date"),
        ("[film]\nexposure = '1'", "2:12: `exposure` must be a number or \"auto\", found a string"),
        ("[film]\nfilter = 1", "2:10: `filter` must be a string, found an integer"),
        ("[integrator]\nmis = 1", "2:7: `mis` must be true or false, found an integer"),
        ("[camera]\norigin = 1", "2:10: `origin` must be an array of 3 numbers, found an integer"),
        ("[camera]\norigin = [1, 2]", "2:10: `origin` must be an array of 3 numbers, found 2"),
        ("[camera]\norigin = [1, 2, 'é']", "2:17: `origin` must be a number, found a string"),
        ("[light]\ntype = 'point'", "1:1: `light` must be an array of tables ([[light]]), found a table"),
        ("mesh = [1]", "1:9: [[mesh]] must be a table, found an integer"),
        (
            "[material.A]\ntype = 'diffuse'\nreflectance = 'a.png'",
            "3:15: `reflectance` must be a number, [r, g, b] or { texture = \"file\" }, found a string",
        ),
        ("[material]\nA = 3", "2:5: [material.A] must be a table, found an integer"),
    ];
    assert_faults(&cases);
}

#[test]
fn numbers_out_of_range_are_refused() {
    let cases = [
        ("[film]\nwidth = 0", "2:9: `width` must be between 1 and 65536, found 0"),
        ("[film]\nheight = 65537", "2:10: `height` must be between 1 and 65536, found 65537"),
        ("[film]\nexposure = nan", "2:12: `exposure` must be finite, found NaN"),
        ("[film]\nexposure = 1e40", "2:12: `exposure` must be finite, found 1e40"),
        ("[cameras.a]\nvfo = 18", "2:1: unknown key `vfo` in [cameras.a]: did you mean `vfov`?"),
        ("[cameras]\na = 18", "2:5: [cameras.a] must be a table, found an integer"),
        ("[camera]\nvfov = 180", "2:8: `vfov` must be greater than 0 and less than 180, found 180"),
        (
            "[camera]\nvfov = 179.9999999999",
            "2:8: `vfov` must be greater than 0 and less than 180, found 179.9999999999",
        ),
        ("[integrator]\nmax_depth = 0", "2:13: `max_depth` must be between 1 and 4294967295, found 0"),
        ("[guiding]\nretain = 1.5", "2:10: `retain` must be between 0 and 1, found 1.5"),
        ("[guiding]\ntable = 'sphere'\nsmoothing = -0.5", "3:13: `smoothing` must be between 0 and 1, found -0.5"),
        ("[guiding]\nlevels = 5", "2:10: `levels` must be between 0 and 4, found 5"),
        ("[guiding]\nresolution = 8193", "2:14: `resolution` must be between 1 and 8192, found 8193"),
        ("[integrator]\nmax_split = 0.5", "2:13: `max_split` must be at least 1, found 0.5"),
        (
            "[guiding]\nlearned_fraction = false\nbsdf_fraction = 0",
            "3:17: `bsdf_fraction` must be greater than 0 and at most 1, found 0",
        ),
        (
            "[guiding]\nmemory = '12 XB'",
            "2:10: `memory` must be 1 or more bytes, or text with a unit \
             (B, KiB, MiB, GiB, TiB, kB, MB, GB or TB)",
        ),
        ("[render]\ntime = inf", "2:8: `time` must be finite and greater than 0, found inf"),
        ("[render]\nseed = -1", "2:8: `seed` must be between 0 and 18446744073709551615, found -1"),
        ("[render]\nseed = 1000000000000000000000000000000000000000", "2:8: this number has too many digits"),
        ("[material.A]\ntype = 'plastic'\nalpha = -0.1", "3:9: `alpha` must be between 0 and 1, found -0.1"),
        ("[material.A]\ntype = 'dielectric'\nint_ior = 0", "3:11: `int_ior` must be greater than 0, found 0"),
        (
            "[material.A]\ntype = 'diffuse'\nreflectance = [0, 1.1, 0]",
            "3:19: `reflectance` must be between 0 and 1, found 1.1",
        ),
        ("[material.A]\ntype = 'null'\nemission = [0, 0, -1]", "3:19: `emission` must be 0 or more, found -1"),
        ("[[light]]\ntype = 'constant'\nradiance = -2", "3:12: `radiance` must be 0 or more, found -2"),
    ];
    assert_faults(&cases);
}

#[test]
fn contradictions_are_refused() {
    let cases = [
        ("[guiding]\nresolution = 8192", "2:14: `resolution` must be at most 128 with method `adaptive`, found 8192"),
        (
            "[guiding]\nresolution = 129\nmethod = 'adaptive'",
            "2:14: `resolution` must be at most 128 with method `adaptive`, found 129",
        ),
        ("[camera]\nup = [0, 0, 0]", "2:6: `up` must not be zero or parallel to the view"),
        ("[camera]\norigin = [1, 0, 0]\ntarget = [1, 0, 0]", "3:10: `target` must differ from `origin`"),
        ("[camera]\ntarget = [1, 2, 0]\norigin = [1, 0, 0]", "2:10: `up` must not be zero or parallel to the view"),
        (
            "[camera]\norigin = [1, 0, 0]\ntarget = [2, 0, 0]\nup = [-3, 0, 0]",
            "4:6: `up` must not be zero or parallel to the view",
        ),
        ("[[mesh]]\nscale = 2", "1:1: [[mesh]] needs `path`"),
        (
            "[[mesh]]\npath = 'a'\nscale = [1, 0, 1]",
            "3:13: `scale` must be other than 0 and between -1e18 and 1e18, found 0",
        ),
        (
            "[[mesh]]\npath = 'a'\nmatrix = [1,0,0,0, 1,0,0,0, 0,0,1,0, 0,0,0,1]",
            "3:10: this transform flattens what it moves: its determinant is 0",
        ),
        (
            "[[mesh]]\npath = 'a'\nmatrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,1,1]",
            "3:10: the last row of `matrix` must be 0, 0, 0, 1",
        ),
        (
            "[[mesh]]\npath = 'a'\nscale = 2\nmatrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]",
            "4:10: `matrix` stands alone: leave out `translate`, `rotate` and `scale`",
        ),
        ("[[mesh]]\npath = 'a'\nrotate = { axis = [0, 0, 0], angle = 3 }", "3:19: `axis` must not be zero"),
        (
            "[[mesh]]\npath = 'a'\nmatrix = [[1,0,0,0], [0,1,0,0]]",
            "3:10: `matrix` must be an array of 16 numbers, found 2",
        ),
        ("[material.A]\ntype = 'conductor'\neta = 1", "3:7: `eta` and `k` go together, but only one is given"),
        (
            "[material.A]\ntype = 'diffuse_transmitter'\nreflectance = 0.8",
            "3:15: `reflectance` and `transmittance` must not add up to more than 1",
        ),
        ("[[light]]\nradiance = 1", "1:1: [[light]] needs `type`"),
        (
            "[[light]]\ntype = 'environment'\npath = 'a.exr'\nto_world = [2,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]",
            "4:12: `to_world` must be a rotation, with or without a reflection",
        ),
        ("[[light]]\ntype = 'environment'\npath = ''", "3:8: `path` must not be empty"),
    ];
    assert_faults(&cases);
}

#[test]
fn faults_of_instances_are_named() {
    let tree = "[[mesh]]\npath = 'tree.obj'\ngroup = 'tree'\n";
    let cases = [
        ("[[instance]]\ngroup = 'tree'", "2:9: unknown group `tree`: no [[mesh]] has the key `group`"),
        ("[[instance]]\nscale = 2", "1:1: [[instance]] needs `group`"),
        ("T[[instance]]\ngroup = 'tre'", "5:9: unknown group `tre` in [[instance]]: did you mean `tree`?"),
        ("T[[instance]]\ngroup = 3", "5:9: `group` must be a string, found an integer"),
        (
            "T[[instance]]\ngroup = 'tree'\ntranslat = [1, 2, 3]",
            "6:1: unknown key `translat` in [[instance]]: did you mean `translate`?",
        ),
        (
            "T[[instance]]\ngroup = 'tree'\npath = 'a'",
            "6:1: unknown key `path` in [[instance]]: known are `group`, `scale`, `rotate`, `translate` and `matrix`",
        ),
        ("T[[instance]]\ngroup = 'tree'\ntranslate = [1, nan, 3]", "6:17: `translate` must be finite, found NaN"),
        (
            "T[[instance]]\ngroup = 'tree'\nscale = [1, 0, 3]",
            "6:13: `scale` must be other than 0 and between -1e18 and 1e18, found 0",
        ),
        (
            "T[[instance]]\ngroup = 'tree'\nmatrix = [1,2,3,0, 2,4,6,0, 0,0,1,0]",
            "6:10: this transform flattens what it moves: its determinant is 0",
        ),
        (
            "T[[instance]]\ngroup = 'tree'\nmatrix = [inf,0,0,0, 0,1,0,0, 0,0,1,0]",
            "6:11: `matrix` must be finite, found inf",
        ),
    ];
    let cases = cases.map(|(text, fault)| (text.replacen('T', tree, 1), fault));
    assert_faults(&cases.each_ref().map(|(text, fault)| (text.as_str(), *fault)));
}

#[test]
fn syntax_errors_have_a_place() {
    let cases = [
        ("[film]\nwidth = 1\nwidth = 2", "3:1: duplicate key"),
        ("[film]\nwidth = [1", "2:11: unclosed array, expected `]`"),
        ("[film\n", "1:6: unclosed table, expected `]`"),
    ];
    assert_faults(&cases);
}
